// SPDX-License-Identifier: GPL-3.0-or-later
// Quantiles of the error estimates of a picture that is still being rendered.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <vector>

namespace penumbra {

/// Counts finite floats, not negative and not denormal, by their exponent and the first five bits of their
/// mantissa: adding and asking cost the same however many there are.
class ErrorHistogram {
 public:
  void add(float value) {
    ++counts_[std::bit_cast<uint32_t>(std::max(value, 0.0f)) >> kShift];
    ++total_;
  }

  /// The share-quantile, at most 1/32 of it too large and never too small; 0 before the first value.
  double quantile(double share) const {
    uint64_t left = total_ ? uint64_t(double(total_ - 1) * share) : 0;
    for (uint32_t bin = 0; bin < counts_.size() && total_; ++bin) {
      if (left < counts_[bin])
        return bin == 0 ? 0 : double(std::bit_cast<float>(((bin + 1) << kShift) - 1));  // largest of the bin
      left -= counts_[bin];
    }
    return 0;
  }

 private:
  static constexpr uint32_t kShift = 23 - 5;
  std::vector<uint64_t> counts_ = std::vector<uint64_t>(1u << (31 - kShift));  // without the sign's bit
  uint64_t total_ = 0;
};

}  // namespace penumbra
