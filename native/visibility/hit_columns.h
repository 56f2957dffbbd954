// SPDX-License-Identifier: GPL-3.0-or-later
// Rays, what they meet, and that of a packet as columns: the arithmetic of surface points for all at once.
#pragma once

#include <cstdint>

#include "math/vector.h"
#include "sampling/sampler.h"
#include "scene/object_traits.h"

namespace penumbra {

/// A ray in render space, in double; rounded only when it is handed to Embree. t is in units of `direction`.
struct Ray {
  Vec3d origin, direction;
  double t_near = 0, t_far = 0;
  RayMask mask = kCameraRay;  // its kind
  double time = 0.5;          // of the shutter: 0 where it opens, 1 where it closes
};

/// Which triangle a ray meets first. Distance and position follow from surface_point().
struct Hit {
  static constexpr uint32_t kNone = ~0u;
  uint32_t instance = kNone, triangle = kNone;
  // Of strands: along the segment, and where Embree found it, in units of the ray's direction.
  float u = 0;
  double t = 0;

  bool found() const { return instance != kNone; }
};

/// Columns of vectors: x, y and z of each.
struct VectorColumns {
  alignas(64) double x[kPacket], y[kPacket], z[kPacket];

  void set(uint32_t i, const Vec3d& v) { x[i] = v.x, y[i] = v.y, z[i] = v.z; }
  Vec3d get(uint32_t i) const { return {x[i], y[i], z[i]}; }
};

/// Filled by Geometry::find_surfaces(). Columns are of those rays that meet triangles.
struct HitColumns {
  const Ray* rays;
  Hit hits[kPacket];
  uint32_t column[kPacket];  // of each ray
  uint32_t ray[kPacket];     // of each column
  uint32_t count = 0;        // columns

  // In the space of the mesh where it is shared, else in render space:
  VectorColumns origin, direction, corner, edge1, edge2;
  alignas(64) double u[kPacket], v[kPacket], t[kPacket];
  // In render space:
  VectorColumns towards;  // the ray's direction
  VectorColumns position, geometric_normal, normal;
  alignas(64) double orientation[kPacket];
  alignas(64) double extent[kPacket];  // of a shared mesh's instance; else below 0: the edges tell
  alignas(64) double rounding[kPacket];
  alignas(64) double side[kPacket];  // -1 where the ray comes from behind
};

}  // namespace penumbra
