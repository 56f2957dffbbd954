// SPDX-License-Identifier: GPL-3.0-or-later
// What a ray finds.
#pragma once

#include <cstdint>

#include "scene/attributes.h"

namespace penumbra {

/// A point of a surface in render space, with what lighting needs to know. One is kept for every pixel, so no
/// more than that.
struct SurfacePoint {
  Vec3d position;
  Vec3d geometric_normal, normal;  // unit, on the viewer's side of the surface; `normal` is interpolated
  double t;                        // along the ray that found it
  double rounding;                 // how far from the surface a ray must start in order not to meet it again
  uint32_t material;
  uint32_t receiver_set = 0;  // of its instance
  double time = 0.5;          // of the shutter, as the ray's
};

/// With what materials need to know.
struct PlacedPoint : SurfacePoint {
  SurfacePlace place;
};

}  // namespace penumbra
