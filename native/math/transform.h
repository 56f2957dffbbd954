// SPDX-License-Identifier: GPL-3.0-or-later
// Affine transforms in double, named `target_from_source`, and boxes.
#pragma once

#include <array>
#include <limits>

#include "math/vector.h"

namespace penumbra {

/// x -> x_axis * x.x + y_axis * x.y + z_axis * x.z + origin.
struct Affine {
  Vec3d x_axis{1, 0, 0}, y_axis{0, 1, 0}, z_axis{0, 0, 1}, origin{};

  Vec3d vector(const Vec3d& v) const { return x_axis * v.x + y_axis * v.y + z_axis * v.z; }
  Vec3d point(const Vec3d& p) const { return vector(p) + origin; }
  double determinant() const { return dot(x_axis, cross(y_axis, z_axis)); }
  bool finite() const {
    return is_finite(x_axis) && is_finite(y_axis) && is_finite(z_axis) && is_finite(origin);
  }

  /// Carries normals: the cofactor matrix, which is det * inverse transpose and needs no division, so that
  /// it survives singular transforms. Lengths are not kept; orientation flips with the determinant's sign.
  Vec3d normal(const Vec3d& n) const {
    return cross(y_axis, z_axis) * n.x + cross(z_axis, x_axis) * n.y + cross(x_axis, y_axis) * n.z;
  }

  /// Inverse of the linear part applied to v. The determinant must not be zero.
  Vec3d inverse_vector(const Vec3d& v) const {
    const double d = 1.0 / determinant();
    return Vec3d{dot(cross(y_axis, z_axis), v), dot(cross(z_axis, x_axis), v),
                 dot(cross(x_axis, y_axis), v)} *
           d;
  }
  Vec3d inverse_point(const Vec3d& p) const { return inverse_vector(p - origin); }
};

/// target_from_middle * middle_from_source.
inline Affine operator*(const Affine& a, const Affine& b) {
  return {a.vector(b.x_axis), a.vector(b.y_axis), a.vector(b.z_axis), a.point(b.origin)};
}

/// Axis-aligned box; empty when made.
struct Box {
  Vec3d low{1, 1, 1}, high{-1, -1, -1};

  bool empty() const { return low.x > high.x; }
  Vec3d centre() const { return low * 0.5 + high * 0.5; }
  Vec3d extent() const { return high - low; }
  void include(const Vec3d& p) {
    if (empty()) {
      low = high = p;
      return;
    }
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  void include(const Box& b) {
    if (!b.empty()) include(b.low), include(b.high);
  }
  std::array<Vec3d, 8> corners() const {
    std::array<Vec3d, 8> c;
    for (int i = 0; i < 8; ++i)
      c[i] = {i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z};
    return c;
  }
};

}  // namespace penumbra
