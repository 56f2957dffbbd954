// SPDX-License-Identifier: GPL-3.0-or-later
#include "visibility/shadow_rays.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <optional>

#include "math/simd.h"
#include "sampling/hash.h"

namespace penumbra {
namespace {

/// Embree refuses directions beyond 1.8e18: those beyond kFar are shrunk, and reach as much further.
constexpr float kFar = 1e18f, kShrink = 0x1p-40f;

/// Of so many packets. Sets the number of rays of each.
PENUMBRA_VECTORIZED
void fill(const ShadowOrigin& origin, RayMask mask, uint32_t packets, const float* x, const float* y,
          const float* z, const float* contribution, RTCRay16* rays, int* valid, int* count) {
  const ShadowOrigin o = origin;
  for (uint32_t p = 0; p < packets; ++p, x += kPacket, y += kPacket, z += kPacket) {
    RTCRay16& packet = rays[p];
    for (uint32_t i = 0; i < kPacket; ++i) {
      const bool front =
          x[i] * o.geometric_normal.x + y[i] * o.geometric_normal.y + z[i] * o.geometric_normal.z >= 0;
      packet.org_x[i] = front ? o.front.origin.x : o.back.origin.x;
      packet.org_y[i] = front ? o.front.origin.y : o.back.origin.y;
      packet.org_z[i] = front ? o.front.origin.z : o.back.origin.z;
      packet.dir_x[i] = x[i] + (front ? o.front.to_surface_point.x : o.back.to_surface_point.x);
      packet.dir_y[i] = y[i] + (front ? o.front.to_surface_point.y : o.back.to_surface_point.y);
      packet.dir_z[i] = z[i] + (front ? o.front.to_surface_point.z : o.back.to_surface_point.z);
      const float size = std::max(std::abs(x[i]), std::max(std::abs(y[i]), std::abs(z[i])));
      const float shrink = size > kFar ? kShrink : 1.0f;
      packet.dir_x[i] *= shrink, packet.dir_y[i] *= shrink, packet.dir_z[i] *= shrink;
      packet.tnear[i] = 0.0f;
      packet.tfar[i] = kShadowReach / shrink;
      packet.time[i] = o.time;
      packet.mask[i] = mask;
    }
    int rays_of_packet = 0;
    for (uint32_t i = 0; i < kPacket; ++i) {
      const int wanted = contribution[p * kPacket + i] > 0 ? -1 : 0;
      valid[p * kPacket + i] = wanted;
      rays_of_packet -= wanted;
    }
    count[p] = rays_of_packet;
  }
}

/// Where rays to one side of each surface point start.
PENUMBRA_VECTORIZED
void find_side(const SurfaceColumns& s, double sign, ShadowOrigins::Side& __restrict side) {
  const uint32_t count = s.count;
  for (uint32_t i = 0; i < count; ++i) {
    const double off = sign * s.rounding[i];
    const float x = float(s.x[i] + s.geometric_x[i] * off), y = float(s.y[i] + s.geometric_y[i] * off),
                z = float(s.z[i] + s.geometric_z[i] * off);
    side.x[i] = x, side.y[i] = y, side.z[i] = z;
    side.dx[i] = float(s.x[i] - double(x)), side.dy[i] = float(s.y[i] - double(y)),
    side.dz[i] = float(s.z[i] - double(z));
  }
}

PENUMBRA_VECTORIZED
void find_rays(const ShadowOrigins& o, const float* x, const float* y, const float* z,
               ShadowRayColumns& __restrict out) {
  const uint32_t count = o.count;
  for (uint32_t i = 0; i < count; ++i) {
    // Both sides are read: a choice of what to read would not be vectorised.
    const float fx = o.front.x[i], fy = o.front.y[i], fz = o.front.z[i], fdx = o.front.dx[i],
                fdy = o.front.dy[i], fdz = o.front.dz[i];
    const float bx = o.back.x[i], by = o.back.y[i], bz = o.back.z[i], bdx = o.back.dx[i], bdy = o.back.dy[i],
                bdz = o.back.dz[i];
    const bool front = x[i] * o.normal_x[i] + y[i] * o.normal_y[i] + z[i] * o.normal_z[i] >= 0;
    const float size = std::max(std::abs(x[i]), std::max(std::abs(y[i]), std::abs(z[i])));
    const float shrink = size > kFar ? kShrink : 1.0f;
    const float ox = front ? fx : bx, oy = front ? fy : by, oz = front ? fz : bz;
    const float dx = (x[i] + (front ? fdx : bdx)) * shrink, dy = (y[i] + (front ? fdy : bdy)) * shrink,
                dz = (z[i] + (front ? fdz : bdz)) * shrink;
    out.org_x[i] = ox, out.org_y[i] = oy, out.org_z[i] = oz;
    out.dir_x[i] = dx, out.dir_y[i] = dy, out.dir_z[i] = dz;
    out.tfar[i] = kShadowReach / shrink;
    out.time[i] = o.time[i];
    // Sums of magnitudes: finite where all are.
    const float reach = std::abs(ox) + std::abs(oy) + std::abs(oz),
                length = std::abs(dx) + std::abs(dy) + std::abs(dz);
    out.usable[i] = reach < INFINITY && length < INFINITY && length > 0;
  }
}

/// Embree sets tfar of a ray that meets something to minus infinity.
PENUMBRA_VECTORIZED
void clear_hidden(const RTCRay16* rays, uint32_t packets, float* contribution) {
  for (uint32_t p = 0; p < packets; ++p, contribution += kPacket)
    for (uint32_t i = 0; i < kPacket; ++i) contribution[i] = rays[p].tfar[i] < 0 ? 0.0f : contribution[i];
}

/// All light is left as yet.
void prepare(RTCRay16& packet, float* transmittance) {
  for (uint32_t i = 0; i < kPacket; ++i) {
    packet.id[i] = i;
    transmittance[i] = 1;
  }
}

/// 0 ... 1, by the ray alone: the same in every packet.
float draw(const RTCRay16& packet, uint32_t i) {
  const auto bits = [](float x) { return uint64_t(std::bit_cast<uint32_t>(x)); };
  return float(hash_of(bits(packet.org_x[i]), bits(packet.org_y[i]), bits(packet.org_z[i]),
                       bits(packet.dir_x[i]), bits(packet.dir_y[i]), bits(packet.dir_z[i])) >>
               40) *
         0x1p-24f;
}

}  // namespace

ShadowSide shadow_side(const SurfacePoint& surface, double sign) {
  const Vec3f origin(surface.position + surface.geometric_normal * (sign * surface.rounding));
  return {origin, Vec3f(surface.position - Vec3d(origin))};
}

ShadowOrigins::ShadowOrigins(const SurfaceColumns& surfaces) : count(surfaces.count) {
  find_side(surfaces, 1, front);
  find_side(surfaces, -1, back);
  for (uint32_t i = 0; i < count; ++i) {
    normal_x[i] = float(surfaces.geometric_x[i]), normal_y[i] = float(surfaces.geometric_y[i]),
    normal_z[i] = float(surfaces.geometric_z[i]);
    time[i] = float(surfaces.time[i]);
  }
}

ShadowRayColumns::ShadowRayColumns(const ShadowOrigins& origins, const float* x, const float* y,
                                   const float* z) {
  find_rays(origins, x, y, z, *this);
}

ShadowRays::ShadowRays(const Geometry& geometry, const SurfacePoint& surface, ShadowKind kind)
    : geometry_(geometry),
      origin_{Vec3f(surface.geometric_normal), shadow_side(surface, 1), shadow_side(surface, -1),
              float(surface.time)},
      kind_(kind),
      usable_(is_finite(origin_.front.origin) && is_finite(origin_.back.origin)) {}

uint32_t ShadowRays::hide(uint32_t count, const float* x, const float* y, const float* z, float* contribution,
                          int* traced) const {
  constexpr uint32_t kMostPackets = kBatch / kPacket;
  alignas(64) RTCRay16 rays[kMostPackets];
  int rays_of_packet[kMostPackets];
  const uint32_t packets = count / kPacket;
  fill(origin_, kind_.mask, packets, x, y, z, contribution, rays, traced, rays_of_packet);
  if (!usable_) return 0;
  alignas(64) float transmittance[kPacket];
  uint8_t channels[kPacket];
  if (geometry_.has_transparency()) std::fill_n(channels, kPacket, kind_.channel);
  uint32_t sum = 0;
  for (uint32_t p = 0; p < packets; ++p) {
    if (rays_of_packet[p] == 0) continue;
    sum += uint32_t(rays_of_packet[p]);
    if (geometry_.has_transparency()) prepare(rays[p], transmittance);
    embree::occluded16(traced + p * kPacket, geometry_.embree_scene(), rays[p], &geometry_, transmittance,
                       channels, geometry_.has_coherent_shadows());
    if (geometry_.has_transparency())
      for (uint32_t i = 0; i < kPacket; ++i) contribution[p * kPacket + i] *= transmittance[i];
  }
  // After all packets: what Embree has just stored in parts can't be loaded as a whole for a while.
  clear_hidden(rays, packets, contribution);
  return sum;
}

void ShadowQueue::add(const ShadowRayColumns& rays, uint32_t i, ShadowKind kind, uint8_t& visible) {
  visible = 0;
  if (!rays.usable[i]) return;
  const uint32_t k = count_++;
  packet_.org_x[k] = rays.org_x[i], packet_.org_y[k] = rays.org_y[i], packet_.org_z[k] = rays.org_z[i];
  packet_.dir_x[k] = rays.dir_x[i], packet_.dir_y[k] = rays.dir_y[i], packet_.dir_z[k] = rays.dir_z[i];
  packet_.tnear[k] = 0, packet_.tfar[k] = rays.tfar[i], packet_.time[k] = rays.time[i],
  packet_.mask[k] = kind.mask;
  valid_[k] = -1;
  results_[k] = &visible;
  channels_[k] = kind.channel;
  if (count_ == kPacket) flush();
}

void ShadowQueue::flush() {
  if (!count_) return;
  alignas(64) float transmittance[kPacket];
  prepare(packet_, transmittance);
  embree::occluded16(valid_, geometry_.embree_scene(), packet_, &geometry_, transmittance, channels_, false);
  for (uint32_t i = 0; i < count_; ++i) {
    *results_[i] = packet_.tfar[i] >= 0 && (transmittance[i] == 1 || draw(packet_, i) < transmittance[i]);
    valid_[i] = 0;
  }
  traced_ += count_;
  count_ = 0;
}

uint32_t hide_from_each(const Geometry& geometry, const SurfaceColumns& surfaces, const uint32_t* group,
                        ShadowKind kind, uint32_t points, const float* x, const float* y, const float* z,
                        float* contribution) {
  const uint32_t surface_count = surfaces.count;
  const ShadowOrigins origins(surfaces);
  std::optional<ShadowRayColumns> rays[kMostPoints];
  for (uint32_t k = 0; k < points; ++k)
    rays[k].emplace(origins, x + k * surface_count, y + k * surface_count, z + k * surface_count);
  alignas(64) RTCRay16 packet;
  alignas(64) int valid[kPacket];
  alignas(64) float transmittance[kPacket];
  uint8_t channels[kPacket];
  std::fill_n(packet.tnear, kPacket, 0.0f);
  std::fill_n(packet.mask, kPacket, kind.mask);
  std::fill_n(channels, kPacket, kind.channel);
  uint32_t traced = 0;
  for (uint32_t begin = 0, end; begin < surface_count; begin = end) {
    for (end = begin + 1; end < surface_count && end < begin + kShare; ++end)
      if (group[end] != group[begin]) break;
    std::fill_n(valid, kPacket, 0);
    uint32_t count = 0;
    for (uint32_t k = 0; k < points; ++k) {
      const uint32_t lane = k * kShare;
      // kShare of each, though some may be another group's.
      const auto copy = [=](float* to, const float* from) {
        std::memcpy(to + lane, from + begin, kShare * sizeof(float));
      };
      copy(packet.org_x, rays[k]->org_x), copy(packet.org_y, rays[k]->org_y);
      copy(packet.org_z, rays[k]->org_z), copy(packet.dir_x, rays[k]->dir_x);
      copy(packet.dir_y, rays[k]->dir_y), copy(packet.dir_z, rays[k]->dir_z);
      copy(packet.tfar, rays[k]->tfar), copy(packet.time, rays[k]->time);
      for (uint32_t i = begin; i < end; ++i) {
        const bool wanted = contribution[k * surface_count + i] > 0 && rays[k]->usable[i];
        valid[lane + i - begin] = wanted ? -1 : 0;
        count += wanted;
      }
    }
    if (count == 0) continue;
    traced += count;
    if (geometry.has_transparency()) prepare(packet, transmittance);
    embree::occluded16(valid, geometry.embree_scene(), packet, &geometry, transmittance, channels, false);
    for (uint32_t k = 0; k < points; ++k) {
      for (uint32_t i = begin; i < end; ++i) {
        const uint32_t lane = k * kShare + i - begin;
        if (!valid[lane]) continue;
        float& left = contribution[k * surface_count + i];
        left = packet.tfar[lane] < 0 ? 0.0f : left;
        if (geometry.has_transparency()) left *= transmittance[lane];
      }
    }
  }
  return traced;
}

}  // namespace penumbra
