// SPDX-License-Identifier: GPL-3.0-or-later
// Points over pixel, luminaire, lens and time together, for antialiasing inside the error promise.
#pragma once

#include <cstdint>
#include <vector>

#include "sampling/sequences.h"

namespace penumbra {

/// Owen-scrambled Sobol', independent for each key. Samples with the same index belong together.
class PixelLightSampler {
 public:
  /// Tables for indices below `count`; `lens_and_time`: for these, too.
  PixelLightSampler(uint32_t count, uint32_t seed, bool lens_and_time);

  /// Places in the pixel of samples [first, first + count), multiples of 2^-24 in [0, 1). key: the pixel.
  void pixel(uint64_t key, uint32_t first, uint32_t count, float* u, float* v) const {
    scramble(&pixel_[first], key, count, u, v);
  }
  /// Places on a luminaire. key: pixel, luminaire and number of mirrors before.
  void light(uint64_t key, uint32_t first, uint32_t count, float* u, float* v) const {
    scramble(&light_[first], key, count, u, v);
  }
  /// Places on the lens. key: the pixel.
  void lens(uint64_t key, uint32_t first, uint32_t count, float* u, float* v) const;
  /// Times. key: the pixel.
  void time(uint64_t key, uint32_t first, uint32_t count, float* u) const;

 private:
  void scramble(const FixedPoint2* reversed, uint64_t key, uint32_t count, float* u, float* v) const;

  uint32_t seed_;
  std::vector<FixedPoint2> pixel_, light_, lens_, time_;  // digits reversed
};

}  // namespace penumbra
