// SPDX-License-Identifier: GPL-3.0-or-later
// Many surface points as columns, for loops over all of them at once.
#pragma once

#include <cstdint>

#include "scene/surface_point.h"

namespace penumbra {

/// Points handled at a time: four packets keep the vectorised loops long and the arrays in the first cache.
inline constexpr uint32_t kBatch = 64;

/// Positions, shading normals and receiver sets of up to kBatch surface points, render space.
struct SurfaceColumns {
  alignas(64) double x[kBatch], y[kBatch], z[kBatch];
  alignas(64) double normal_x[kBatch], normal_y[kBatch], normal_z[kBatch];
  uint32_t receiver_set[kBatch];
  uint32_t count = 0;

  void add(const SurfacePoint& point) {
    x[count] = point.position.x, y[count] = point.position.y, z[count] = point.position.z;
    normal_x[count] = point.normal.x, normal_y[count] = point.normal.y, normal_z[count] = point.normal.z;
    receiver_set[count] = point.receiver_set;
    ++count;
  }

  /// Position and normal of one of them; nothing else is known.
  SurfacePoint point(uint32_t i) const {
    const Vec3d normal{normal_x[i], normal_y[i], normal_z[i]};
    return {{x[i], y[i], z[i]}, normal, normal, 0, 0, 0, {}, receiver_set[i]};
  }
};

}  // namespace penumbra
