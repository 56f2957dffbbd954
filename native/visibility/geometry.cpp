// SPDX-License-Identifier: GPL-3.0-or-later
// Rays against the placed geometry.
#include "visibility/geometry.h"

#include <limits>

#include "math/simd.h"

namespace penumbra {
namespace {

constexpr uint32_t kWidth = 16;

/// Rays before they are rounded, as columns.
struct RayColumns {
  VectorColumns origin, direction;
  alignas(64) double t_near[kWidth], t_far[kWidth];
  alignas(64) double shrink[kWidth];
};

/// Cuts t_near and t_far to where each ray is inside the box, so that a camera far away still starts its
/// single-precision rays near the scene. A ray that misses has t_near > t_far then. The box is widened by a
/// rounding error.
PENUMBRA_VECTORIZED
void clip_to_box(const Box& box, double margin, RayColumns& rays) {
  const Vec3d low = box.low, high = box.high;
  double *t_near = rays.t_near, *t_far = rays.t_far;
  const auto clip = [=](const double* origin, const double* direction, double from, double to) {
    for (uint32_t i = 0; i < kWidth; ++i) {
      const double inverse = 1 / direction[i];
      const bool crosses = std::abs(inverse) <= std::numeric_limits<double>::max();
      const bool outside = !(origin[i] >= from && origin[i] <= to);  // of a slab that it never leaves
      const double a = (from - origin[i]) * inverse, b = (to - origin[i]) * inverse;
      const double enters = crosses ? (a < b ? a : b) : (outside ? 1e300 : -1e300),
                   leaves = crosses ? (a < b ? b : a) : (outside ? -1e300 : 1e300);
      t_near[i] = enters > t_near[i] ? enters : t_near[i];
      t_far[i] = leaves < t_far[i] ? leaves : t_far[i];
    }
  };
  clip(rays.origin.x, rays.direction.x, low.x - margin, high.x + margin);
  clip(rays.origin.y, rays.direction.y, low.y - margin, high.y + margin);
  clip(rays.origin.z, rays.direction.z, low.z - margin, high.z + margin);
}

/// What Embree gets; valid: in, whether a ray counts; out, and whether it can be traced.
PENUMBRA_VECTORIZED
void round(const RayColumns& rays, RTCRayHit16& packet, int* valid) {
  constexpr float kMost = std::numeric_limits<float>::max();
  for (uint32_t i = 0; i < kWidth; ++i) {
    const double t = rays.t_near[i], shrink = rays.shrink[i];
    const float ox = float(rays.origin.x[i] + rays.direction.x[i] * t),
                oy = float(rays.origin.y[i] + rays.direction.y[i] * t),
                oz = float(rays.origin.z[i] + rays.direction.z[i] * t);
    const float dx = float(rays.direction.x[i] * shrink), dy = float(rays.direction.y[i] * shrink),
                dz = float(rays.direction.z[i] * shrink);
    const float length = float((rays.t_far[i] - t) / shrink);
    packet.ray.org_x[i] = ox, packet.ray.org_y[i] = oy, packet.ray.org_z[i] = oz;
    packet.ray.dir_x[i] = dx, packet.ray.dir_y[i] = dy, packet.ray.dir_z[i] = dz;
    packet.ray.tnear[i] = 0, packet.ray.tfar[i] = length;
    packet.ray.id[i] = i, packet.ray.flags[i] = 0;
    packet.hit.geomID[i] = packet.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
    // Sums of magnitudes: finite where all are.
    const float size = std::abs(dx) + std::abs(dy) + std::abs(dz),
                reach = std::abs(ox) + std::abs(oy) + std::abs(oz);
    const bool usable = size > 0 && size <= kMost && reach <= kMost && length <= kMost && length >= 0;
    valid[i] = valid[i] && usable ? -1 : 0;
  }
}

/// Embree refuses directions beyond 1.8e18, and single precision loses those below 1e-38: their exponent is
/// taken out.
double shrink_of(double size) {
  return size > 1e-9 && size < 1e9 ? 1.0 : std::scalbn(1.0, -std::ilogb(size));
}

}  // namespace

void Geometry::intersect(const Ray* rays, uint32_t active, Hit* hits) const {
  alignas(64) RTCRayHit16 packet;
  alignas(64) int valid[kWidth];
  RayColumns columns;
  for (uint32_t i = 0; i < kWidth; ++i) {
    valid[i] = active >> i & 1;
    static const Ray nothing{};
    const Ray& ray = valid[i] ? rays[i] : nothing;
    if (valid[i]) hits[i] = Hit{};
    const double size = max_abs(ray.direction);
    valid[i] = valid[i] && size > 0 && std::isfinite(size) && is_finite(ray.origin);
    columns.origin.set(i, ray.origin);
    columns.direction.set(i, ray.direction);
    columns.t_near[i] = ray.t_near, columns.t_far[i] = ray.t_far;
    columns.shrink[i] = valid[i] ? shrink_of(size) : 1.0;
    packet.ray.time[i] = float(ray.time), packet.ray.mask[i] = ray.mask;
  }
  if (bounds_.empty()) return;
  clip_to_box(bounds_, 1e-6 * (1 + max_abs(bounds_.extent())), columns);
  round(columns, packet, valid);
  embree::intersect16(valid, scene_.get(), packet, !has_shared_meshes_);
  for (uint32_t i = 0; i < kWidth; ++i) {
    if (!valid[i] || packet.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) continue;
    const bool instanced = packet.hit.instID[0][i] != RTC_INVALID_GEOMETRY_ID;
    const uint32_t instance = instanced ? packet.hit.instID[0][i] : packet.hit.geomID[i];
    hits[i] = {instance, mesh_of(instance).whole(packet.hit.primID[i]), packet.hit.u[i],
               columns.t_near[i] + double(packet.ray.tfar[i]) * columns.shrink[i]};
  }
}

}  // namespace penumbra
