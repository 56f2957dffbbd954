// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/sample_packet.h"

#include <algorithm>
#include <cmath>

#include "lighting/bounded_item.h"
#include "lighting/lobe_colours.h"
#include "sampling/hash.h"

namespace penumbra {
namespace {

/// Share of the tolerance that dim luminaires may be charged for being left out of the ray count.
constexpr double kDropShare = 0.125;

}  // namespace

FilteredFrame make_frame(const RenderContext& c, const Rectangle& area, const Block& block) {
  const bool glossy =
      std::ranges::any_of(c.scene.materials(), [](const Material& m) { return m.may_be_glossy(); });
  const uint32_t slots = uint32_t(c.luminaires.size()) * c.paths.length() * (glossy ? 2 : 1);
  return {area,
          block.width,
          glossy,
          slots,
          std::vector<Slot>(size_t(block.pixels()) * slots),
          std::vector<uint8_t>(block.pixels()),
          std::vector<uint8_t>(block.pixels())};
}

SamplePacket::SamplePacket(const RenderContext& context, const FilteredFrame& frame, RenderTally& tally)
    : c_(context),
      frame_(frame),
      tally_(tally),
      display_scale_(std::exp2(context.settings.exposure)),
      tolerance_(context.settings.error_tolerance),
      luminaires_(uint32_t(context.luminaires.size())),
      lobes_(frame.glossy ? 2 : 1),
      queue_(context.geometry) {
  if (c_.extras.want_parts()) parts.emplace(kPacket, c_.extras.light_groups());
  if (c_.extras.want_mattes()) mattes.resize(kPacket);
  if (c_.extras.any()) seen.resize(kPacket);
  // The queue points into it.
  visible_.reserve(size_t(kPacket) * context.paths.length() * luminaires_);
}

uint64_t SamplePacket::frame_pixel(uint32_t p) const {
  return uint64_t(frame_.area.y + p / frame_.block_width) * c_.settings.width + frame_.area.x +
         p % frame_.block_width;
}

bool SamplePacket::mirrored(const Contribution& one) const {
  const uint32_t bounce = one.slot / lobes_ / luminaires_;
  return std::ranges::any_of(
      points_, [&](const LitPoint& p) { return p.pixel == one.lane && p.bounce == bounce && p.mirrored; });
}

void SamplePacket::trace(std::span<const SampleRun> runs) {
  tally_.light.stop_if_cancelled();
  find_points(runs);
  contributions_.clear();
  dropped_.clear();
  visible_.clear();
  const uint64_t traced_before = queue_.traced();
  for (uint32_t begin = 0; begin < points_.size(); begin += kBatch) {
    const uint32_t end = std::min(begin + kBatch, uint32_t(points_.size()));
    SurfaceColumns columns;
    for (uint32_t k = begin; k < end; ++k) columns.add(points_[k].surface);
    for (uint32_t l = 0; l < luminaires_; ++l) light(runs, l, begin, end, columns);
  }
  queue_.flush();
  if (!dropped_.empty()) add_dropped();
  tally_.light.shadow_rays += queue_.traced() - traced_before;
}

/// Camera rays, and the surface points that they see.
void SamplePacket::find_points(std::span<const SampleRun> runs) {
  Ray rays[kPacket];
  PixelSamples samples[kPacket];
  uint32_t lane = 0;
  for (size_t r = 0; r < runs.size(); ++r) {
    const SampleRun& run = runs[r];
    const uint64_t frame = frame_pixel(run.pixel);
    samples[r] = {frame_.area.x + run.pixel % frame_.block_width,
                  frame_.area.y + run.pixel / frame_.block_width,
                  {frame, run.first, run.count}};
    for (uint32_t i = 0; i < run.count; ++i, ++lane) {
      lanes_[lane] = {run.pixel, run.first + i, frame};
      charge[lane] = 0;
      rays_of[lane] = 0;
    }
  }
  c_.pixel_rays.make({samples, runs.size()}, rays, dx, dy);
  HitColumns found;
  c_.geometry.find_surfaces(rays, lane, found);
  tally_.primary_rays += lane;
  points_.clear();
  const bool recorded = c_.extras.any();
  if (parts) parts->clear();
  for (std::vector<MatteHit>& one : mattes) one.clear();
  for (uint32_t i = 0; i < lane; ++i) {
    PathRecord record{.mist = &c_.settings.mist};
    if (parts) record.parts = parts->of(i);
    if (!mattes.empty()) record.mattes = &mattes[i];
    if (recorded) record.seen = &(seen[i] = {});
    c_.paths.follow(found, i, i, 0, points_, tally_.mirror_rays, ends[i], recorded ? &record : nullptr);
  }
}

/// A point of the luminaire for each of the surface points [begin, end).
void SamplePacket::place_on_light(std::span<const SampleRun> runs, uint32_t luminaire, uint32_t begin,
                                  uint32_t end, float* u, float* v) const {
  alignas(64) float lane_u[kPacket], lane_v[kPacket];
  SampleRange ranges[kPacket];
  uint32_t lane = 0;
  for (size_t r = 0; r < runs.size(); lane += runs[r++].count)
    ranges[r] = {hash_of(lanes_[lane].frame_pixel, luminaire * lobes_), runs[r].first, runs[r].count};
  c_.pixel_light_sampler.light({ranges, runs.size()}, lane_u, lane_v);
  for (uint32_t k = begin; k < end; ++k) {
    const Lane& at = lanes_[points_[k].pixel];
    u[k - begin] = lane_u[points_[k].pixel], v[k - begin] = lane_v[points_[k].pixel];
    if (points_[k].bounce == 0) continue;
    const uint32_t slot = (points_[k].bounce * luminaires_ + luminaire) * lobes_;
    const SampleRange one{hash_of(at.frame_pixel, slot), at.index, 1};
    c_.pixel_light_sampler.light({&one, 1}, u + (k - begin), v + (k - begin));
  }
}

/// First looks go everywhere, and where penumbra was found all samples do. At edges what lies between two
/// surfaces may hide luminaires from a part of the pixel that no sample has met yet: there another ray a
/// sample looks at one luminaire after the other.
bool SamplePacket::wants_ray(const Lane& lane, const Slot& slot, uint32_t luminaire) const {
  if (lane.index < kFirstSamples || slot.uncertain) return true;
  return frame_.edge[lane.pixel] && (lane.index + luminaire) % luminaires_ == 0;
}

int64_t SamplePacket::add_ray(const LitPoint& lit, const Luminaire& luminaire, const Vec3f& to_light) {
  visible_.push_back(1);
  ++rays_of[lit.pixel];
  if (luminaire.casts_shadow()) queue_.add(lit.surface, to_light, luminaire.shadow_kind(), visible_.back());
  return int64_t(visible_.size()) - 1;
}

/// What one luminaire sends to the surface points [begin, end).
void SamplePacket::light(std::span<const SampleRun> runs, uint32_t l, uint32_t begin, uint32_t end,
                         const SurfaceColumns& columns) {
  const Luminaire& luminaire = c_.luminaires[l];
  alignas(64) double form_factors[kBatch];
  alignas(64) float u[kBatch], v[kBatch];
  LightPoints on_light;
  luminaire.form_factors(columns, form_factors);
  place_on_light(runs, l, begin, end, u, v);
  luminaire.evaluate_each(columns, u, v, on_light);
  for (uint32_t k = begin; k < end; ++k) {
    const LitPoint& lit = points_[k];
    const uint32_t lane = lit.pixel, i = k - begin;
    if (form_factors[i] <= 0) {
      ++tally_.light.decided_without_ray;
      continue;
    }
    const ShadingPoint shading(lit.surface, *lit.material, lit.ray_direction);
    const Vec3d arriving = lit.throughput * luminaire.radiance();
    const DiffuseColour colour = diffuse_colour(shading, luminaire);
    const Vec3d diffuse = arriving * colour.mean * form_factors[i];
    const double size = max_abs(diffuse) * display_scale_;
    // Too dim for a ray.
    if (luminaires_ > 1 && !shading.has_glossy && charge[lane] + size / 2 <= kDropShare * tolerance_) {
      charge[lane] += size / 2;
      ++tally_.light.decided_without_ray;
      dropped_.push_back({k, l, diffuse});
      continue;
    }
    const uint32_t s = (lit.bounce * luminaires_ + l) * lobes_;
    const Slot* slot = &frame_.of_pixel(lanes_[lane].pixel)[s];
    const bool wanted = wants_ray(lanes_[lane], *slot, l) || (frame_.glossy && slot[1].uncertain);
    const Vec3f to_light(on_light.x[i], on_light.y[i], on_light.z[i]);
    const float sampled = on_light.form_factor[i];
    const int64_t ray = wanted && sampled > 0 ? add_ray(lit, luminaire, to_light) : kNoRay;
    if (size > 0) {
      float weight = sampled;
      weigh_diffuse(shading, &to_light.x, &to_light.y, &to_light.z, 1, &weight);
      const double mean = form_factors[i] * colour.weight;
      contributions_.push_back({lane, s, diffuse, size * double(weight) / mean, ray});
    }
    if (!shading.has_glossy || !luminaire.role().glossy) continue;
    // No closed form: the sampled value itself stands for the unshadowed one.
    Reflection lobe;
    add_reflection(shading, &to_light.x, &to_light.y, &to_light.z, &sampled, 1, lobe);
    const Vec3d specular = lit.material->has_glossy_lobes ? arriving * lobe.glossy
                                                          : arriving * lit.material->phong * lobe.weight;
    if (lobe.weight > 0)
      contributions_.push_back({lane, s + 1, specular, max_abs(specular) * display_scale_, ray});
  }
}

/// A sample sees of the dropped luminaires what it sees of the others.
void SamplePacket::add_dropped() {
  uint32_t lit[kPacket] = {}, dark[kPacket] = {};
  for (const Contribution& one : contributions_) {
    const bool seen = one.ray != kNoRay ? sees(one) : frame_.of_pixel(pixel(one.lane))[one.slot].lit;
    ++(seen ? lit : dark)[one.lane];
  }
  for (const Dropped& one : dropped_) {
    const LitPoint& at = points_[one.point];
    const double share = expected_share(lit[at.pixel], dark[at.pixel]);
    ends[at.pixel].background += one.diffuse * share;
    if (parts)
      add_light(parts->of(at.pixel), c_.luminaires[one.luminaire], at, {one.diffuse * share, one.diffuse},
                {});
  }
  // It was charged with half of each, which is the most.
  for (uint32_t lane = 0; lane < kPacket; ++lane)
    charge[lane] *= 2 * share_deviation(expected_share(lit[lane], dark[lane]));
}

}  // namespace penumbra
