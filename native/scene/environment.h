// SPDX-License-Identifier: GPL-3.0-or-later
// A picture of the whole sky.
#pragma once

#include <cstdint>
#include <vector>

#include "math/transform.h"

namespace penumbra {

/// Equirectangular: columns go from azimuth pi down to -pi (atan2(y, x)), rows from straight down up.
struct Environment {
  uint32_t width, height;
  std::vector<Vec3f> pixels;  // radiance; row 0 is the lowest
  Affine local_from_world;    // a rotation
  bool smooth = true;         // interpolated between the centres of pixels

  /// Radiance from a direction in the world, of any length.
  Vec3d radiance(const Vec3d& to_sky) const;
};

}  // namespace penumbra
