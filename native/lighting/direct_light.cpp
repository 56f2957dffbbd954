// SPDX-License-Identifier: GPL-3.0-or-later
#include "lighting/direct_light.h"

#include <algorithm>
#include <memory>

#include "lighting/lobe_colours.h"
#include "sampling/hash.h"
#include "visibility/shadow_rays.h"

namespace penumbra {

namespace {

/// Of glossy lobes, r, g, b, by light point.
struct LobeColours {
  Vec3f seen[kBatch], unshadowed[kBatch];
};

}  // namespace

class DirectLight::OnBlock final : public BlockLighting {
 public:
  OnBlock(const DirectLight& how, const LitBlock& block)
      : how_(how), b_(block), variance_(block.memory, block.out.size()) {}

  void look() override {
    for (; done_ < b_.points.size(); ++done_) light(b_.points[done_]);
  }

  /// Error: twice the standard error of independent points, the largest of r, g, b; for points more even than
  /// independent ones the true error is smaller.
  void finish() override {
    look();
    for (size_t i = 0; i < b_.out.size(); ++i)
      b_.out[i].error = 2 * std::sqrt(max_component(variance_[i])) * how_.display_scale_;
  }

 private:
  void light(const LitPoint& lit) {
    const ShadingPoint point(lit.surface, *lit.material, lit.ray_direction);
    PixelLight& pixel = b_.out[lit.pixel];
    for (size_t i = 0; i < b_.luminaires.size(); ++i) {
      const Luminaire& luminaire = b_.luminaires[i];
      const uint64_t index = lit.stream * b_.luminaires.size() + i;
      Parts apart;
      const Estimate one =
          how_.from(luminaire, point, {index, hash_of(index)}, b_.tally, b_.parts ? &apart : nullptr);
      pixel.radiance += lit.throughput * one.radiance;
      pixel.points += one.points;
      if (b_.parts)
        add_light(b_.parts->of(lit.pixel), luminaire, lit,
                  {lit.throughput * apart.diffuse.seen, lit.throughput * apart.diffuse.unshadowed},
                  {lit.throughput * apart.glossy.seen, lit.throughput * apart.glossy.unshadowed});
      pixel.at_limit = pixel.at_limit || one.at_limit;
      variance_[lit.pixel] += lit.throughput * lit.throughput * one.variance;
      if (b_.tally.trace)
        b_.tally.trace->add(lit.pixel, {lit.bounce, uint32_t(i),
                                        one.points == 0 ? "unseen"
                                        : one.at_limit  ? "at the limit"
                                                        : "the rule is satisfied",
                                        one.points, lit.throughput * one.radiance});
    }
  }

  const DirectLight& how_;
  LitBlock b_;
  Reused<Vec3d> variance_;  // by pixel
  size_t done_ = 0;         // of the points
};

std::unique_ptr<BlockLighting> DirectLight::begin(const LitBlock& block) const {
  return std::make_unique<OnBlock>(*this, block);
}

DirectLight::Estimate DirectLight::from(const Luminaire& luminaire, const ShadingPoint& point,
                                        const StreamKey& key, LightTally& tally, Parts* parts) const {
  if (!point.material.reflects() || luminaire.unseen_from(point.surface)) {
    ++tally.decided_without_ray;
    return {};
  }
  // A grid tells the rule of the colour of glossy lobes, but sharp ones may lie between its points: what is
  // drawn tells the picture.
  const bool has_lobes = point.material.has_glossy_lobes && luminaire.role().glossy,
             is_fixed = stop_.kind == StopRuleKind::kFixed;
  const Vec3d diffuse = luminaire.radiance() * diffuse_colour(point, luminaire).of_weight();
  Vec3d glossy;
  if (!has_lobes || !is_fixed) glossy = luminaire.radiance() * glossy_colour(point, luminaire);

  const ShadowRays rays(geometry_, point.surface, luminaire.shadow_kind());
  StopRule rule(stop_, diffuse, glossy);
  Moments moments;
  double all_diffuse = 0, all_glossy = 0;  // sums without shadows, if parts are wanted
  Vec3d seen_colours, all_colours;         // of the lobes, likewise
  // An optional one would be zeroed always: three per cent of a render without such lobes.
  const auto colours = has_lobes ? std::make_unique<LobeColours>() : nullptr;
  alignas(64) float u[kBatch], v[kBatch], specular[kBatch], unshadowed[kBatch], unshadowed_specular[kBatch];
  alignas(64) int ray_of[kBatch];
  LightPoints points;
  float* f = points.form_factor;
  const float *x = points.x, *y = points.y, *z = points.z;
  // The growing rules decide after few points: a packet at a time wastes least.
  const uint32_t step = is_fixed ? kBatch : kPacket;
  const uint32_t limit = luminaire.is_point() ? 1 : stop_.limit();
  uint64_t traced = 0;
  bool done = false;
  uint32_t until_check = rule.next_check(0);
  for (uint32_t first = 0; first < limit && !done; first += step) {
    tally.stop_if_cancelled();
    const uint32_t used = std::min(step, limit - first);
    const uint32_t generated = (used + kPacket - 1) / kPacket * kPacket;
    sampler_.points(key, first, generated, u, v);
    luminaire.evaluate(point.surface, u, v, generated, points);
    std::fill(f + used, f + generated, 0.0f);  // generated, but not asked for
    if (parts) {
      std::copy(f, f + used, unshadowed);
      if (point.has_glossy)
        evaluate_glossy(point, x, y, z, unshadowed, used, unshadowed_specular,
                        colours ? colours->unshadowed : nullptr);
      weigh_diffuse(point, x, y, z, used, unshadowed);
    }
    if (luminaire.casts_shadow()) traced += rays.hide(generated, x, y, z, f, ray_of);
    if (point.has_glossy)
      evaluate_glossy(point, x, y, z, f, used, specular, colours ? colours->seen : nullptr);
    weigh_diffuse(point, x, y, z, used, f);
    // The rule sees the points as if they came one by one.
    uint32_t added = 0;
    while (added < used && !done) {
      const uint32_t n = std::min(until_check, used - added);
      moments.add(f + added, point.has_glossy ? specular + added : nullptr, n);
      added += n;
      until_check -= n;
      if (until_check > 0) continue;
      done = rule.enough(moments);
      until_check = rule.next_check(uint32_t(moments.count));
    }
    for (uint32_t i = 0; parts && i < added; ++i) {
      all_diffuse += double(unshadowed[i]);
      if (point.has_glossy) all_glossy += double(unshadowed_specular[i]);
    }
    for (uint32_t i = 0; colours && i < added; ++i) {
      seen_colours += Vec3d(colours->seen[i]);
      if (parts) all_colours += Vec3d(colours->unshadowed[i]);
    }
    for (uint32_t i = added; luminaire.casts_shadow() && i < used; ++i)
      tally.shadow_rays_beyond_stop += uint64_t(-ray_of[i]);
  }
  tally.light_points += uint64_t(moments.count);
  tally.shadow_rays += traced;
  if (traced == 0) ++tally.decided_without_ray;
  Vec3d unshadowed_glossy = glossy * all_glossy;
  if (has_lobes) {
    glossy = moments.p > 0 ? luminaire.radiance() * seen_colours / moments.p : Vec3d{};
    unshadowed_glossy = luminaire.radiance() * all_colours;
  }
  if (parts && moments.count > 0)
    *parts = {{moments.mean(diffuse, {}), diffuse * (all_diffuse / moments.count)},
              {moments.mean({}, glossy), unshadowed_glossy / moments.count}};
  return {moments.mean(diffuse, glossy), moments.variance_of_mean(diffuse, glossy), uint64_t(moments.count),
          !done && !luminaire.is_point()};
}

}  // namespace penumbra
