// SPDX-License-Identifier: GPL-3.0-or-later
#include "lighting/direct_light.h"

#include <bit>

#include "sampling/hash.h"
#include "visibility/shadow_rays.h"

namespace penumbra {

DirectLight::DirectLight(const Geometry& geometry, const std::vector<AreaLuminaire>& luminaires,
                         const Sampler& sampler, const StopSettings& stop)
    : geometry_(geometry), sampler_(sampler), stop_(stop) {
  for (const AreaLuminaire& description : luminaires) {
    const Luminaire luminaire(description, geometry.normalization());
    if (!luminaire.dark()) luminaires_.push_back(luminaire);
  }
}

LightEstimate DirectLight::at(const ShadingPoint& point, uint64_t stream, LightTally& tally) const {
  LightEstimate sum;
  for (size_t i = 0; i < luminaires_.size(); ++i) {
    const uint64_t index = stream * luminaires_.size() + i;
    const LightEstimate one = from(luminaires_[i], point, {index, hash_of(index)}, tally);
    sum.radiance += one.radiance;
    sum.variance += one.variance;
  }
  return sum;
}

LightEstimate DirectLight::from(const Luminaire& luminaire, const ShadingPoint& point, const StreamKey& key,
                                LightTally& tally) const {
  const Material& material = point.material;
  const Vec3d diffuse = luminaire.radiance() * material.diffuse,
              phong = luminaire.radiance() * material.phong;
  if ((max_abs(diffuse) == 0 && !point.has_phong) || luminaire.unseen_from(point.surface)) {
    ++tally.decided_without_ray;
    return {};
  }

  const ShadowRays rays(geometry_, point.surface);
  StopRule rule(stop_, diffuse, phong);
  Moments moments;
  alignas(64) float u[kBatch], v[kBatch], specular[kBatch];
  LightPoints points;
  // The growing rules decide after few points: a packet at a time wastes least.
  const uint32_t step = stop_.kind == StopRuleKind::kFixed ? kBatch : kPacket;
  const uint32_t limit = stop_.limit();
  uint64_t traced = 0;
  bool done = false;
  uint32_t until_check = rule.next_check(0);
  for (uint32_t first = 0; first < limit && !done; first += step) {
    const uint32_t used = std::min(step, limit - first);
    const uint32_t generated = (used + kPacket - 1) / kPacket * kPacket;
    sampler_.points(key, first, generated, u, v);
    luminaire.evaluate(point.surface, u, v, generated, points);
    if (point.has_phong)
      evaluate_phong(point, points.x, points.y, points.z, points.form_factor, generated, specular);

    for (uint32_t packet = 0; packet < used && !done; packet += kPacket) {
      const uint32_t size = std::min(kPacket, used - packet);
      float* f = points.form_factor + packet;
      float* p = point.has_phong ? specular + packet : nullptr;
      uint32_t active = 0;
      for (uint32_t i = 0; i < size; ++i) active |= uint32_t(f[i] > 0) << i;
      if (luminaire.casts_shadow()) {
        const uint32_t seen = rays.visible(points.x + packet, points.y + packet, points.z + packet, active);
        traced += std::popcount(active);
        for (uint32_t i = 0; i < size; ++i) {
          const bool visible = seen >> i & 1;
          f[i] = visible ? f[i] : 0.0f;
          if (p) p[i] = visible ? p[i] : 0.0f;
        }
      }
      // The rule sees the points as if they came one by one.
      uint32_t added = 0;
      while (added < size && !done) {
        const uint32_t n = std::min(until_check, size - added);
        moments.add(f + added, p ? p + added : nullptr, n);
        added += n;
        until_check -= n;
        if (until_check > 0) continue;
        done = rule.enough(moments);
        until_check = rule.next_check(uint32_t(moments.count));
      }
      if (luminaire.casts_shadow()) tally.shadow_rays_beyond_stop += std::popcount(active >> added & 0xFFFFu);
    }
  }
  tally.light_points += uint64_t(moments.count);
  tally.shadow_rays += traced;
  if (traced == 0) ++tally.decided_without_ray;
  tally.at_limit = tally.at_limit || !done;
  return {moments.mean(diffuse, phong), moments.variance_of_mean(diffuse, phong)};
}

}  // namespace penumbra
