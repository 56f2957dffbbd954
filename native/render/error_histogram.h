// SPDX-License-Identifier: GPL-3.0-or-later
// Quantiles of the error estimates of a picture that is still being rendered.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <span>
#include <vector>

namespace penumbra {

/// Counts finite floats, not negative and not denormal, by their exponent and the first five bits of their
/// mantissa: adding and asking cost the same however many there are.
class ErrorHistogram {
 public:
  void add(float value) {
    ++counts_[bin_of(value)];
    ++total_;
  }

  /// The share-quantile, at most 1/32 of it too large and never too small; 0 before the first value.
  double quantile(double share) const {
    const Place at = place(share);
    return at.bin == 0 ? 0
                       : double(std::bit_cast<float>(((at.bin + 1) << kShift) - 1));  // largest of the bin
  }

  /// The same, exactly; values: those that were added, in any order. Only those of one bin are sorted out.
  double exact_quantile(double share, std::span<const float> values) const {
    const Place at = place(share);
    std::vector<float> near;
    for (float value : values)
      if (bin_of(value) == at.bin) near.push_back(std::max(value, 0.0f));
    if (at.rank >= near.size()) return 0;
    std::nth_element(near.begin(), near.begin() + std::ptrdiff_t(at.rank), near.end());
    return double(near[at.rank]);
  }

 private:
  static constexpr uint32_t kShift = 23 - 5;

  static uint32_t bin_of(float value) { return std::bit_cast<uint32_t>(std::max(value, 0.0f)) >> kShift; }

  /// Where in which bin the share-quantile lies.
  struct Place {
    uint32_t bin = 0;
    uint64_t rank = 0;
  };
  Place place(double share) const {
    Place at{0, total_ ? uint64_t(double(total_ - 1) * share) : 0};
    for (; total_ && at.rank >= counts_[at.bin]; ++at.bin) at.rank -= counts_[at.bin];
    return at;
  }

  std::vector<uint64_t> counts_ = std::vector<uint64_t>(1u << (31 - kShift));  // without the sign's bit
  uint64_t total_ = 0;
};

}  // namespace penumbra
