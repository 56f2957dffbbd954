// SPDX-License-Identifier: GPL-3.0-or-later
// Where the scene is placed for computing with it.
#pragma once

#include "math/transform.h"

namespace penumbra {

/// world -> render space: subtract the scene's centre, then scale by a power of two to about unit size, so
/// that single precision serves a micrometre scene at an offset of 1e7 as well as any other.
struct Normalization {
  Vec3d centre;
  double scale = 1;

  Vec3d point(const Vec3d& world) const { return (world - centre) * scale; }
  Vec3d world_point(const Vec3d& render) const { return render / scale + centre; }
  Affine transform(const Affine& world_from_source) const {
    return {world_from_source.x_axis * scale, world_from_source.y_axis * scale,
            world_from_source.z_axis * scale, point(world_from_source.origin)};
  }
};

}  // namespace penumbra
