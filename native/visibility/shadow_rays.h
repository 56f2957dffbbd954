// SPDX-License-Identifier: GPL-3.0-or-later
// What part of a luminaire does a point see? Answered by packets of rays to points on the luminaire.
#pragma once

#include "sampling/sampler.h"
#include "scene/surface_columns.h"
#include "visibility/geometry.h"

namespace penumbra {

/// Where rays to one side of a surface start: moved off it by its rounding error, then rounded.
struct ShadowSide {
  Vec3f origin, to_surface_point;
};

/// sign: 1 or -1, that of the geometric normal or the other.
ShadowSide shadow_side(const SurfacePoint& surface, double sign);

/// Rays end this fraction short of the luminaire, so that a face in the luminaire's own plane (a lamp's
/// glass, a ceiling it is let into) is on neither side of a rounding error.
inline constexpr float kShadowReach = 1.0f - 0x1p-18f;

/// A smooth normal can light a point from behind its own facet; only other facets may shadow it then, so rays
/// to either side start on that side.
struct ShadowOrigin {
  Vec3f geometric_normal;
  ShadowSide front, back;
  float time;
};

/// Shadow rays from one shading point, of a kind.
class ShadowRays {
 public:
  ShadowRays(const Geometry& geometry, const SurfacePoint& surface, ShadowKind kind = {});

  /// Traces rays to those of `count` points whose contribution is positive, and sets the contribution of each
  /// that something hides to zero; transparent surfaces leave a part of it. count: whole packets, kBatch at
  /// most. x, y, z: from the shading point to each, finite where the contribution is positive. traced[i]: -1
  /// where a ray was traced, else 0. Returns the number of rays.
  uint32_t hide(uint32_t count, const float* x, const float* y, const float* z, float* contribution,
                int* traced) const;

 private:
  const Geometry& geometry_;
  ShadowOrigin origin_;
  ShadowKind kind_;
  bool usable_;
};

/// ShadowOrigin of each of many surface points, as columns.
struct ShadowOrigins {
  explicit ShadowOrigins(const SurfaceColumns& surfaces);

  struct Side {
    alignas(64) float x[kBatch], y[kBatch], z[kBatch];     // origin
    alignas(64) float dx[kBatch], dy[kBatch], dz[kBatch];  // from there to the surface point
  };
  alignas(64) float normal_x[kBatch], normal_y[kBatch], normal_z[kBatch];
  Side front, back;
  alignas(64) float time[kBatch];
  uint32_t count;
};

/// A shadow ray from each of them, as Embree wants it.
struct ShadowRayColumns {
  /// x, y, z: from the surface points to what each looks at.
  ShadowRayColumns(const ShadowOrigins& origins, const float* x, const float* y, const float* z);

  alignas(64) float org_x[kBatch], org_y[kBatch], org_z[kBatch], dir_x[kBatch], dir_y[kBatch], dir_z[kBatch];
  alignas(64) float tfar[kBatch], time[kBatch];
  alignas(64) int usable[kBatch];
};

/// Shadow rays from many shading points to a point each, traced a packet at a time.
class ShadowQueue {
 public:
  explicit ShadowQueue(const Geometry& geometry) : geometry_(geometry) {}

  /// One ray of columns, which ends on the luminaire. `visible` is set to 1 or 0 at the latest by flush(),
  /// and must live until then. Behind transparent surfaces it is 1 with the share of the light that they
  /// leave as probability, drawn by the ray alone.
  void add(const ShadowRayColumns& rays, uint32_t i, ShadowKind kind, uint8_t& visible);
  void flush();

  uint64_t traced() const { return traced_; }

 private:
  const Geometry& geometry_;
  alignas(64) RTCRay16 packet_;
  alignas(64) int valid_[kPacket] = {};
  uint8_t* results_[kPacket];
  uint8_t channels_[kPacket];
  uint32_t count_ = 0;
  uint64_t traced_ = 0;
};

/// As ShadowRays::hide(), for a few points for each of at most kPacket surface points: number k *
/// surfaces.count + i is point k for surface i. At most kShare neighbours of the same group, and no others,
/// share a packet: what a ray meets may depend, by rounding, on the rays around it.
inline constexpr uint32_t kShare = 4, kMostPoints = kPacket / kShare;
uint32_t hide_from_each(const Geometry& geometry, const SurfaceColumns& surfaces, const uint32_t* group,
                        ShadowKind kind, uint32_t points, const float* x, const float* y, const float* z,
                        float* contribution);

}  // namespace penumbra
