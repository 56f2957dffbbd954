// SPDX-License-Identifier: GPL-3.0-or-later
// Closed forms in double, written from their formulas and not from the engine, and random numbers for trials.
#pragma once

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "math/transform.h"
#include "scene/scene.h"
#include "scene/surface_point.h"

namespace penumbra::test {

inline constexpr double kPi = 3.14159265358979323846;

/// The polygon's part above the plane through `point` with normal n (Sutherland and Hodgman 1974).
inline std::vector<Vec3d> above_horizon(const std::vector<Vec3d>& polygon, const Vec3d& point,
                                        const Vec3d& n) {
  std::vector<Vec3d> out;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Vec3d a = polygon[i], b = polygon[(i + 1) % polygon.size()];
    const double ha = dot(a - point, n), hb = dot(b - point, n);
    if (ha >= 0) out.push_back(a);
    if ((ha > 0 && hb < 0) || (ha < 0 && hb > 0)) out.push_back(a + (b - a) * (ha / (ha - hb)));
  }
  return out;
}

/// Lambert's form factor of a flat polygon as seen from a surface element, both sides of the polygon
/// emitting: F = |sum_i Gamma_i n . c_i / |c_i|| / (2 pi), c_i = a_i x (a_(i+1) - a_i), Gamma_i =
/// atan2(|c_i|, a_i . a_(i+1)).
inline double lambert_form_factor(const std::vector<Vec3d>& polygon, const Vec3d& point, const Vec3d& n) {
  const std::vector<Vec3d> p = above_horizon(polygon, point, n);
  double sum = 0;
  for (size_t i = 0; i < p.size(); ++i) {
    const Vec3d a = p[i] - point, edge = p[(i + 1) % p.size()] - p[i], c = cross(a, edge);
    const double size = length(c);
    if (size > 0) sum += std::atan2(size, dot(a, a + edge)) * dot(n, c) / size;
  }
  return std::abs(sum) / (2 * kPi);
}

/// Parallel disk of radius r at height h, its centre displaced sideways by d.
inline double disk_form_factor(double r, double h, double d) {
  const double s = d * d + h * h + r * r;
  return 0.5 * (1 - (d * d + h * h - r * r) / std::sqrt(s * s - 4 * r * r * d * d));
}

/// Seeded random numbers for trials.
class Trials {
 public:
  explicit Trials(uint32_t seed) : engine_(seed) {}
  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  Vec3d vector(double size) { return {uniform(-size, size), uniform(-size, size), uniform(-size, size)}; }
  Vec3d direction() {
    for (;;) {
      const Vec3d v = vector(1);
      const double l = length(v);
      if (l > 0.1 && l < 1) return v / l;
    }
  }
  /// Sheared, scaled, mirrored half of the time; never near singular.
  Affine transform(double size) {
    for (;;) {
      const Affine t{vector(1), vector(1), vector(1), vector(size)};
      if (std::abs(t.determinant()) > 0.1) return t;
    }
  }
  /// Rotation and translation.
  Affine rigid(double size) {
    const Vec3d z = direction(), x = normalize(cross(z, direction()));
    return {x, cross(z, x), z, vector(size)};
  }

 private:
  std::mt19937 engine_;
};

/// A point to be lit, facing `normal`.
inline SurfacePoint surface_at(const Vec3d& position, const Vec3d& normal) {
  return {position, normal, normal, 0, 0, 0};
}

/// A luminaire of unit radiance.
inline AreaLuminaire light(LuminaireShape shape, const Affine& transform, double size_x, double size_y) {
  return {"light", shape, transform, size_x, size_y, {1, 1, 1}, true};
}

}  // namespace penumbra::test
