// SPDX-License-Identifier: GPL-3.0-or-later
#include "visibility/shadow_rays.h"

namespace penumbra {
namespace {

/// Rays end this fraction short of the luminaire, so that a face in the luminaire's own plane (a lamp's
/// glass, a ceiling it is let into) is on neither side of a rounding error.
constexpr float kReach = 1.0f - 0x1p-18f;

}  // namespace

ShadowRays::ShadowRays(const Geometry& geometry, const SurfacePoint& surface)
    : geometry_(geometry), geometric_normal_(surface.geometric_normal) {
  const auto side = [&](double sign) {
    const Vec3f origin(surface.position + surface.geometric_normal * (sign * surface.rounding));
    return Side{origin, Vec3f(surface.position - Vec3d(origin))};
  };
  front_ = side(1);
  back_ = side(-1);
  usable_ = is_finite(front_.origin) && is_finite(back_.origin);
}

uint32_t ShadowRays::visible(const float* x, const float* y, const float* z, uint32_t active) const {
  if (!active || !usable_) return 0;
  alignas(64) RTCRay16 packet;
  alignas(64) int valid[kPacket];
  const Vec3f n = geometric_normal_;
  for (uint32_t i = 0; i < kPacket; ++i) {
    valid[i] = -int(active >> i & 1);
    // A smooth normal can light a point from behind its own facet; only other facets may shadow it then.
    const bool front = x[i] * n.x + y[i] * n.y + z[i] * n.z >= 0;
    packet.org_x[i] = front ? front_.origin.x : back_.origin.x;
    packet.org_y[i] = front ? front_.origin.y : back_.origin.y;
    packet.org_z[i] = front ? front_.origin.z : back_.origin.z;
    packet.dir_x[i] = x[i] + (front ? front_.to_surface_point.x : back_.to_surface_point.x);
    packet.dir_y[i] = y[i] + (front ? front_.to_surface_point.y : back_.to_surface_point.y);
    packet.dir_z[i] = z[i] + (front ? front_.to_surface_point.z : back_.to_surface_point.z);
    packet.tnear[i] = 0.0f;
    packet.tfar[i] = kReach;
    packet.time[i] = 0.0f;
    packet.mask[i] = ~0u;
    packet.id[i] = i;
    packet.flags[i] = 0;
  }
  embree::occluded16(valid, geometry_.embree_scene(), packet);
  uint32_t seen = 0;
  for (uint32_t i = 0; i < kPacket; ++i)
    seen |= uint32_t(packet.tfar[i] >= 0.0f) << i;  // Embree: -Inf if hit
  return seen & active;
}

}  // namespace penumbra
