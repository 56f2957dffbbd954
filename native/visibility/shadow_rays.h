// SPDX-License-Identifier: GPL-3.0-or-later
// What part of a luminaire does a point see? Answered by packets of rays to points on the luminaire.
#pragma once

#include "sampling/sampler.h"
#include "visibility/geometry.h"

namespace penumbra {

/// Shadow rays from one shading point.
class ShadowRays {
 public:
  ShadowRays(const Geometry& geometry, const SurfacePoint& surface);

  /// Which of kPacket points see the shading point. x, y, z: from the shading point to each, finite where
  /// `active`; bit i of the result is set where active bit i is and nothing lies between.
  uint32_t visible(const float* x, const float* y, const float* z, uint32_t active) const;

 private:
  /// Where rays to one side of the surface start: moved off it by its rounding error, then rounded.
  struct Side {
    Vec3f origin, to_surface_point;
  };

  const Geometry& geometry_;
  Vec3f geometric_normal_;
  Side front_, back_;
  bool usable_;
};

}  // namespace penumbra
