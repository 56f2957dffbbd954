// SPDX-License-Identifier: GPL-3.0-or-later
// What the samples of a filtered pixel found of one luminaire.
#pragma once

#include <cstdint>

#include "math/vector.h"

namespace penumbra {

/// Samples of the first look at every pixel.
inline constexpr uint32_t kFirstSamples = 4;

/// Sums over a pixel's samples for one slot: one luminaire, one lobe, one number of mirrors before.
struct SlotSums {
  Vec3d unshadowed;      // radiance without visibility; exact for the diffuse lobe
  double w = 0, wv = 0;  // weight of the sampled point, and weight times visibility

  friend SlotSums operator-(const SlotSums& a, const SlotSums& b) {
    return {a.unshadowed - b.unshadowed, a.w - b.w, a.wv - b.wv};
  }
};

struct Slot {
  SlotSums now;
  Vec3d fitted;  // unshadowed radiance at the pixel's centre, by a plane through the first samples
  bool lit = false, dark = false;  // seen by some ray
  bool uncertain = false;
  bool split = false;                     // each sample looks at as many points as a packet holds
  uint8_t first_lit = 0, first_dark = 0;  // bits of the points that the pixel's centre looked at
  uint32_t rays = 0;  // samples whose point on the luminaire was above the horizon, and looked at

  Slot() {}  // without it a vector of them is zeroed once more
  /// Radiance from `s`, sums over `count` samples: unshadowed mean x visible fraction.
  Vec3d radiance(const SlotSums& s, double count) const { return s.unshadowed / count * visible(s); }
  Vec3d fitted_radiance() const { return fitted * (lit ? 1.0 : 0.0); }

 private:
  double visible(const SlotSums& s) const {
    if (!uncertain) return lit ? 1.0 : 0.0;
    return s.w > 0 ? s.wv / s.w : now.w > 0 ? now.wv / now.w : 0.0;
  }
};

}  // namespace penumbra
