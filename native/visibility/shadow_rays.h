// SPDX-License-Identifier: GPL-3.0-or-later
// What part of a luminaire does a point see? Answered by packets of rays to points on the luminaire.
#pragma once

#include "sampling/sampler.h"
#include "visibility/geometry.h"

namespace penumbra {

/// Where rays to one side of a surface start: moved off it by its rounding error, then rounded.
struct ShadowSide {
  Vec3f origin, to_surface_point;
};

/// A smooth normal can light a point from behind its own facet; only other facets may shadow it then, so rays
/// to either side start on that side.
struct ShadowOrigin {
  Vec3f geometric_normal;
  ShadowSide front, back;
};

/// Shadow rays from one shading point.
class ShadowRays {
 public:
  ShadowRays(const Geometry& geometry, const SurfacePoint& surface);

  /// Traces rays to those of kPacket points whose contribution is positive, and sets the contribution of each
  /// that something hides to zero. x, y, z: from the shading point to each, finite where the contribution is
  /// positive. traced[i]: -1 where a ray was traced, else 0. Returns the number of rays.
  uint32_t hide(const float* x, const float* y, const float* z, float* contribution, int* traced) const;

 private:
  const Geometry& geometry_;
  ShadowOrigin origin_;
  bool usable_;
};

}  // namespace penumbra
