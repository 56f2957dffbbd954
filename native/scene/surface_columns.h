// SPDX-License-Identifier: GPL-3.0-or-later
// Many surface points as columns, for loops over all of them at once.
#pragma once

#include <cstdint>

#include "scene/surface_point.h"

namespace penumbra {

/// Points handled at a time: four packets keep the vectorised loops long and the arrays in the first cache.
inline constexpr uint32_t kBatch = 64;

/// Up to kBatch surface points, render space: what luminaires and shadow rays want to know.
struct SurfaceColumns {
  alignas(64) double x[kBatch], y[kBatch], z[kBatch];
  alignas(64) double normal_x[kBatch], normal_y[kBatch], normal_z[kBatch];
  alignas(64) double geometric_x[kBatch], geometric_y[kBatch], geometric_z[kBatch];
  alignas(64) double rounding[kBatch], time[kBatch];
  uint32_t receiver_set[kBatch];
  uint32_t count = 0;

  void add(const SurfacePoint& point) {
    x[count] = point.position.x, y[count] = point.position.y, z[count] = point.position.z;
    normal_x[count] = point.normal.x, normal_y[count] = point.normal.y, normal_z[count] = point.normal.z;
    geometric_x[count] = point.geometric_normal.x, geometric_y[count] = point.geometric_normal.y,
    geometric_z[count] = point.geometric_normal.z;
    rounding[count] = point.rounding, time[count] = point.time;
    receiver_set[count] = point.receiver_set;
    ++count;
  }

  void add(const SurfaceColumns& other, uint32_t i) {
    x[count] = other.x[i], y[count] = other.y[i], z[count] = other.z[i];
    normal_x[count] = other.normal_x[i], normal_y[count] = other.normal_y[i],
    normal_z[count] = other.normal_z[i];
    geometric_x[count] = other.geometric_x[i], geometric_y[count] = other.geometric_y[i],
    geometric_z[count] = other.geometric_z[i];
    rounding[count] = other.rounding[i], time[count] = other.time[i];
    receiver_set[count] = other.receiver_set[i];
    ++count;
  }

  /// One of them; its material and distance are not known.
  SurfacePoint point(uint32_t i) const {
    return {{x[i], y[i], z[i]},
            {geometric_x[i], geometric_y[i], geometric_z[i]},
            {normal_x[i], normal_y[i], normal_z[i]},
            0,
            rounding[i],
            0,
            receiver_set[i],
            time[i]};
  }
};

}  // namespace penumbra
