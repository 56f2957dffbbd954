// SPDX-License-Identifier: GPL-3.0-or-later
// Four-dimensional points over pixel and luminaire together, for antialiasing inside the error promise.
#pragma once

#include <cstdint>
#include <vector>

#include "sampling/sequences.h"

namespace penumbra {

/// A point of the unit square in single precision, multiples of 2^-24, never 1.
struct UnitPoint {
  float u, v;
};

/// Owen-scrambled Sobol', independent for each key. Samples with the same index belong together.
class PixelLightSampler {
 public:
  /// Tables for indices below `count`.
  PixelLightSampler(uint32_t count, uint32_t seed);

  /// Place in the pixel. key: the pixel.
  UnitPoint pixel(uint64_t key, uint32_t index) const { return scrambled(pixel_[index], key); }
  /// Place on a luminaire. key: pixel, luminaire and number of mirrors before.
  UnitPoint light(uint64_t key, uint32_t index) const { return scrambled(light_[index], key); }

 private:
  UnitPoint scrambled(FixedPoint2 reversed, uint64_t key) const;

  uint32_t seed_;
  std::vector<FixedPoint2> pixel_, light_;  // digits reversed
};

}  // namespace penumbra
