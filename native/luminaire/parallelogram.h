// SPDX-License-Identifier: GPL-3.0-or-later
// Where a line of sight meets a flat luminaire.
#pragma once

#include <optional>

#include "luminaire/emitter.h"

namespace penumbra {

/// Whether something at t is before the line's end. What lies in the plane of the surface there (a lamp let
/// into a ceiling) counts as before it, as for shadow rays.
inline bool is_before_end(const SightLine& line, double t) {
  constexpr double kReach = 1 + 0x1p-18;
  return t > line.t_near && t <= (line.blocked ? line.t_far * kReach : line.t_far);
}

/// A place on a parallelogram, in coordinates 0 ... 1 along its edges.
struct PlaceOnParallelogram {
  double s, t;

  bool in_ellipse() const { return (s - 0.5) * (s - 0.5) + (t - 0.5) * (t - 0.5) <= 0.25; }
};

/// On the side that `normal` points to, or nothing.
inline std::optional<PlaceOnParallelogram> meet_parallelogram(const SightLine& line, const Vec3d& corner,
                                                              const Vec3d& edge_u, const Vec3d& edge_v,
                                                              const Vec3d& normal) {
  const double facing = -dot(line.direction, normal);
  if (!(facing > 0)) return std::nullopt;
  const Vec3d to_corner = corner - line.origin;
  const double t = -dot(to_corner, normal) / facing;
  if (!is_before_end(line, t)) return std::nullopt;
  const Vec3d from_corner = line.direction * t - to_corner, across = cross(edge_u, edge_v);
  const double square = dot(across, across);
  const PlaceOnParallelogram place{dot(cross(from_corner, edge_v), across) / square,
                                   dot(cross(edge_u, from_corner), across) / square};
  if (!(place.s >= 0 && place.s <= 1 && place.t >= 0 && place.t <= 1)) return std::nullopt;
  return place;
}

}  // namespace penumbra
