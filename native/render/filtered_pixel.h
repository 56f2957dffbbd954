// SPDX-License-Identifier: GPL-3.0-or-later
// What BOUNDED with antialiasing knows of a pixel, and how sure it is of it.
#pragma once

#include <array>
#include <vector>

#include "render/film.h"

namespace penumbra {

/// Samples of the first look at every pixel.
inline constexpr uint32_t kFirstSamples = 4;

/// Sums over a pixel's samples for one slot: one luminaire, one lobe, one number of mirrors before.
struct SlotSums {
  Vec3d unshadowed;       // radiance without visibility, exact for the diffuse lobe
  double w = 0, wv = 0;   // weight of the sampled point, and weight times visibility

  friend SlotSums operator-(const SlotSums& a, const SlotSums& b) {
    return {a.unshadowed - b.unshadowed, a.w - b.w, a.wv - b.wv};
  }
};

struct Slot {
  SlotSums now, half, power;  // now, and at the two powers of two before
  Vec3d fitted;               // first samples' unshadowed radiance at the pixel's centre, by a plane through them
  uint8_t lit = 0, dark = 0;  // rays of the first look
  bool uncertain = false;

  /// Visible fraction, by the rays of `s`, or of all where `s` has none.
  double visible(const SlotSums& s) const;
};

struct FilteredPixel {
  uint32_t count = 0;                                       // samples
  Vec3d background, background_half, background_power;      // sums
  Vec3d background_fitted;
  double x = 0, xx = 0;                                     // sums of each sample's own value, display units
  double fit_residual = 0;                                  // of the plane through the first samples, display units
  double variance = 0;                                      // of the estimate, by its blocks, display units squared
  double alpha = 0, charged = 0;                            // sum; error of what was left out
  uint64_t light_points = 0;
  bool uncertain = false, at_limit = false;
  double error = 0;
  PathEnd first;
};

/// Mean radiance of `count` samples from their sums.
Vec3d filtered_estimate(const std::vector<Slot>& slots, size_t begin, size_t end, const Vec3d& background,
                        double count, SlotSums (*part)(const Slot&));

/// Weights h of four samples at offsets (x, y) from the pixel's centre, such that sum h f is exact there for
/// every linear f: the intercept of the least-squares plane. Equal weights where the points are nearly on a line.
std::array<double, kFirstSamples> plane_weights(const std::array<double, kFirstSamples>& x,
                                                const std::array<double, kFirstSamples>& y);

}  // namespace penumbra
