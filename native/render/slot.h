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
  Vec3d unshadowed;  // radiance without visibility; exact for the diffuse lobe
  Vec3d w, wv;       // weight of the sampled point, and weight times visibility, r, g, b

  /// What one sample's point tells. weight: of the largest of its light's r, g, b; the others, as surfaces of
  /// several hues in one pixel are not hidden alike, have less.
  void add_visibility(const Vec3d& light, double weight, double visible) {
    const double largest = max_abs(light);
    if (!(largest > 0)) return;
    const Vec3d by_channel = absolute(light) / largest * weight;
    w += by_channel;
    wv += by_channel * visible;
  }

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
  Vec3d radiance(const SlotSums& s, double count) const {
    const Vec3d mean = s.unshadowed / count;
    if (!uncertain) return mean * (lit ? 1.0 : 0.0);
    return {mean.x * visible(&Vec3d::x, s), mean.y * visible(&Vec3d::y, s), mean.z * visible(&Vec3d::z, s)};
  }
  Vec3d fitted_radiance() const { return fitted * (lit ? 1.0 : 0.0); }

 private:
  /// Of one channel.
  double visible(double Vec3d::*c, const SlotSums& s) const {
    return s.w.*c > 0 ? s.wv.*c / s.w.*c : now.w.*c > 0 ? now.wv.*c / now.w.*c : 0.0;
  }
};

}  // namespace penumbra
