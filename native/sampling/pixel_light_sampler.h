// SPDX-License-Identifier: GPL-3.0-or-later
// Points over pixel, luminaire, lens and time together, for antialiasing inside the error promise.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sampling/sequences.h"

namespace penumbra {

/// Of a sample, its place on a luminaire.
inline constexpr int kLightDimensions = 2;

/// Consecutive samples of one pixel. key: its stream.
struct SampleRange {
  uint64_t key;
  uint32_t first, count;
};

/// Owen-scrambled Sobol', independent for each key. Samples with the same index belong together.
class PixelLightSampler {
 public:
  /// Tables for indices below `count`; `lens_and_time`: for these, too.
  PixelLightSampler(uint32_t count, uint32_t seed, bool lens_and_time);

  // For at most kPacket samples, range after range.
  /// Places in the pixel, multiples of 2^-24 in [0, 1). key: the pixel.
  void pixel(std::span<const SampleRange> ranges, float* u, float* v) const;
  /// Places on a luminaire. key: pixel, luminaire and number of mirrors before.
  void light(std::span<const SampleRange> ranges, float* u, float* v) const;
  /// Places on the lens. key: the pixel.
  void lens(std::span<const SampleRange> ranges, float* u, float* v) const;
  /// Times. key: the pixel.
  void time(std::span<const SampleRange> ranges, float* u) const;

 private:
  template <typename Seed>
  static void scramble(const std::vector<FixedPoint2>& reversed, std::span<const SampleRange> ranges,
                       Seed seed, float* u, float* v);

  uint32_t seed_;
  std::vector<FixedPoint2> pixel_, light_, lens_, time_;  // digits reversed
};

}  // namespace penumbra
