// SPDX-License-Identifier: GPL-3.0-or-later
// One luminaire seen from one surface point: what BOUNDED knows about it so far.
#pragma once

#include <array>
#include <cmath>

#include "lighting/bounded_light.h"

namespace penumbra {

/// Most points of the first look at every pixel: one in each quarter of the luminaire.
inline constexpr uint32_t kFirstLook = 4;

/// Sums over points, of the integrand f without visibility and of f V, for the diffuse and the Phong lobe.
struct VisibilitySums {
  double f = 0, fv = 0, p = 0, pv = 0;

  friend VisibilitySums operator+(const VisibilitySums& a, const VisibilitySums& b) {
    return {a.f + b.f, a.fv + b.fv, a.p + b.p, a.pv + b.pv};
  }
  friend VisibilitySums operator-(const VisibilitySums& a, const VisibilitySums& b) {
    return {a.f - b.f, a.fv - b.fv, a.p - b.p, a.pv - b.pv};
  }
};

/// What part of the dim luminaires that nobody looks at a place probably sees: as of those it looked at, by
/// so many rays that saw and did not; half, where it looked at none (Laplace's rule of succession).
inline double expected_share(double lit, double dark) {
  return (lit + 1) / (lit + dark + 2);
}

/// What is charged for it, of their sum: the standard deviation as if all of them were seen or none.
inline double share_deviation(double share) {
  return std::sqrt(share * (1 - share));
}

/// The largest of r, g, b, in display units.
inline double light_size(const Vec3d& radiance, double display_scale) {
  return max_abs(radiance) * display_scale;
}

/// What the first look tells.
struct LookedItem {
  uint32_t point = 0, pixel = 0, luminaire = 0;
  Vec3d diffuse, phong;                     // unshadowed radiance in the pixel, by lobe
  double diffuse_size = 0, phong_size = 0;  // the largest of their r, g, b, display units
  uint8_t first_lit = 0, first_dark = 0;    // bits of the first look's points
  uint8_t looks = 0;                        // points of it
  bool looked = false;

  void set_light(const Vec3d& by_diffuse, const Vec3d& by_phong, double display_scale) {
    diffuse = by_diffuse, diffuse_size = light_size(by_diffuse, display_scale);
    phong = by_phong, phong_size = light_size(by_phong, display_scale);
  }
  double size() const { return diffuse_size + phong_size; }
  Vec3d unshadowed() const { return diffuse + phong; }
};

struct BoundedItem : LookedItem {
  BoundedItem(const LookedItem& item) : LookedItem(item) {}

  uint32_t count = 0, lit = 0, facing = 0;         // points used; those seen; those that could contribute
  VisibilitySums sums, at_half, at_power;          // now, and at the two powers of two before
  double variance = 0;                             // own estimate for these points, display units squared
  uint32_t lines = 0;                              // in place of the points, if any; the sums are theirs then
  float line_offset = 0;                           // see Chords::sum(), of all
  double half_variance = 0, quarter_variance = 0;  // estimates for half and a quarter of the lines
  bool never_lines = false;                        // it was tried

  uint32_t used() const { return lines > 0 ? lines : count; }

  /// Ratio estimate of the shadowed radiance.
  Vec3d radiance() const { return diffuse_radiance() + glossy_radiance(); }
  Vec3d diffuse_radiance() const { return diffuse * ratio(sums.fv, sums.f); }
  Vec3d glossy_radiance() const { return phong * ratio(sums.pv, sums.p); }
  double display(const VisibilitySums& s) const {
    return diffuse_size * ratio(s.fv, s.f) + phong_size * ratio(s.pv, s.p);
  }

 private:
  static double ratio(double visible, double all) { return all > 0 ? visible / all : 0.0; }
};

/// The next number of points after n: 16, 32, 48, 64, 96, 128, ...: 2^k and 1.5 x 2^k, in whole packets.
inline uint32_t next_level(uint32_t n) {
  if (n < 16) return 16;
  if (n < 32) return 32;
  uint32_t power = 32;
  while (power * 2 <= n) power *= 2;
  return n == power ? power + power / 2 : power * 2;
}

}  // namespace penumbra
