// SPDX-License-Identifier: GPL-3.0-or-later
// Directions within an angle of an axis: how a sphere, a facing disk or the sun looks to a surface point.
#pragma once

#include "luminaire/emitter.h"

namespace penumbra {

/// Two unit vectors at right angles to an axis and to each other.
struct Across {
  Vec3d side, up;
  explicit Across(const Vec3d& axis)
      : side(normalize(cross(std::abs(axis.z) < 0.7 ? Vec3d{0, 0, 1} : Vec3d{1, 0, 0}, axis))),
        up(cross(axis, side)) {}
};

struct Cone {
  Vec3d axis;           // unit, from the surface point
  double sine_squared;  // of the half angle, at most a right one

  double one_minus_cosine() const;
  double solid_angle() const;

  /// Form factor E / (pi L_e) of constant radiance, the part below the horizon of unit normal n left out.
  double form_factor(const Vec3d& normal) const;
  /// Does the horizon cut it? (It may be wholly below.)
  bool cut_by(const Vec3d& normal) const;
};

/// Where along its direction a point of the cone lies.
enum class ConeDepth { kSphere, kDisk, kDistant };

/// Points of the unit square, uniformly in solid angle: unit directions times their distance, and form
/// factors of each. `distance`: of the sphere's or the disk's centre.
void evaluate_cone(const Cone& cone, ConeDepth depth, double distance, const Vec3d& normal, const float* u,
                   const float* v, uint32_t count, LightPoints& out);

/// The whole sky around a unit normal, with density cos / pi: unit directions, form factors of 1.
void evaluate_hemisphere(const Vec3d& normal, const float* u, const float* v, uint32_t count,
                         LightPoints& out);

/// Longer than any way through the scene in render space, where it spans [-1, 1] in each axis.
inline constexpr float kBeyondScene = 4.0f;

}  // namespace penumbra
