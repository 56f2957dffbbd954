// SPDX-License-Identifier: GPL-3.0-or-later
// Sobol', Halton and Owen-scrambled Sobol' with every treatment from pixel to pixel.
#pragma once

#include <vector>

#include "sampling/hash.h"
#include "sampling/sampler.h"
#include "sampling/sequences.h"

namespace penumbra {

/// A low-discrepancy sequence, from a table of its first points where all pixels start at the same index.
class SequenceSampler final : public Sampler {
 public:
  explicit SequenceSampler(const SamplerSettings& settings);
  void points(const StreamKey& key, uint32_t first, uint32_t count, float* u, float* v) const override;
  void first_points(std::span<const StreamKey> keys, uint32_t count, float* u, float* v) const override;

 private:
  /// Point of the sequence, counted from the index where rendering starts.
  FixedPoint2 base_point(uint64_t index) const;
  void base_points(uint64_t index, uint32_t count, FixedPoint2* out) const;
  /// As the table holds them: in reverse order where they are scrambled.
  uint32_t digits(uint32_t number) const { return owen_ ? reverse_bits(number) : number; }
  void fill_table();

  SamplerSettings settings_;
  const DigitalMatrices* matrices_ = nullptr;  // null: Halton
  uint64_t start_;                             // index of the first point used
  bool owen_;                                  // base-2 nested uniform scrambling in both coordinates
  bool scrambled_halton_;                      // its ternary coordinate has no table
  std::vector<uint32_t> u_, v_, index_;
};

}  // namespace penumbra
