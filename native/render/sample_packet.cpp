// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/sample_packet.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "lighting/bounded_item.h"
#include "lighting/light_batch.h"
#include "lighting/lobe_colours.h"
#include "math/simd.h"
#include "sampling/hash.h"

namespace penumbra {
namespace {

/// Share of the tolerance that dim luminaires may be charged for being left out of the ray count.
constexpr double kDropShare = 0.125;

constexpr int32_t kNoColumn = -1;

/// What Lambert's lobe reflects of a luminaire: unshadowed radiance by the closed form, the largest of its r,
/// g, b in display units, and that of the sampled point.
struct LambertColumns {
  alignas(64) double red[kBatch], green[kBatch], blue[kBatch], size[kBatch], weight[kBatch];
};

/// albedo: red, green and blue of each point. sampled: summands of the form factors.
PENUMBRA_VECTORIZED
void reflect_diffusely(const double (&albedo)[3][kBatch], uint32_t count, const Vec3d& radiance,
                       double display_scale, const double* form_factors, const float* sampled,
                       LambertColumns& __restrict out) {
  const Vec3d light = radiance;
  for (uint32_t i = 0; i < count; ++i) {
    const double f = form_factors[i], red = albedo[0][i] * light.x * f, green = albedo[1][i] * light.y * f,
                 blue = albedo[2][i] * light.z * f;
    const double a = std::abs(red), b = std::abs(green), c = std::abs(blue), ab = a < b ? b : a;
    const double size = (ab < c ? c : ab) * display_scale;
    out.red[i] = red, out.green[i] = green, out.blue[i] = blue;
    out.size[i] = size;
    out.weight[i] = size * double(sampled[i]) / f;
  }
}

}  // namespace

/// Surface points [begin, end), as columns.
struct SamplePacket::Batch {
  Batch(const LitPoint* points, uint32_t first, uint32_t last);

  uint32_t begin, end;
  SurfaceColumns surfaces;
  uint32_t lane[kBatch], bounce[kBatch];
  /// Of Lambert's lobe, by r, g, b, with the mirrors before it; not where there is more than that.
  alignas(64) double albedo[3][kBatch];
  bool lambert[kBatch];
};

SamplePacket::Batch::Batch(const LitPoint* points, uint32_t first, uint32_t last) : begin(first), end(last) {
  for (uint32_t i = 0; i < end - begin; ++i) {
    const LitPoint& point = points[begin + i];
    surfaces.add(point.surface);
    lane[i] = point.pixel;
    bounce[i] = point.bounce;
    lambert[i] = !point.material->has_diffuse_lobes && !point.material->has_glossy();
    const Vec3d colour = point.throughput * point.material->diffuse;
    albedo[0][i] = colour.x, albedo[1][i] = colour.y, albedo[2][i] = colour.z;
  }
}

FilteredFrame make_frame(const RenderContext& c, const Rectangle& area, const Block& block) {
  const bool glossy =
      std::ranges::any_of(c.scene.materials(), [](const Material& m) { return m.may_be_glossy(); });
  const uint32_t slots = uint32_t(c.luminaires.size()) * c.paths.length() * (glossy ? 2 : 1);
  return {area,
          block.width,
          glossy,
          slots,
          {c.memory, size_t(block.pixels()) * slots},
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
      queue_(context.geometry),
      column_of_(frame.slot_count, kNoColumn) {
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

bool SamplePacket::mirrored(const SlotColumns& column, uint32_t lane) const {
  const uint32_t bounce = column.slot / lobes_ / luminaires_;
  return std::ranges::any_of(
      points_, [&](const LitPoint& p) { return p.pixel == lane && p.bounce == bounce && p.mirrored; });
}

/// Those of a slot, begun if it is new to the packet.
SlotColumns& SamplePacket::columns_of(uint32_t slot) {
  if (column_of_[slot] == kNoColumn) {
    column_of_[slot] = int32_t(contributions_.size());
    contributions_.emplace_back(slot);
  }
  return contributions_[size_t(column_of_[slot])];
}

void SamplePacket::trace(std::span<const SampleRun> runs) {
  tally_.light.stop_if_cancelled();
  find_points(runs);
  for (const SlotColumns& column : contributions_) column_of_[column.slot] = kNoColumn;
  contributions_.clear();
  dropped_.clear();
  visible_.clear();
  const uint64_t traced_before = queue_.traced();
  for (uint32_t begin = 0; begin < points_.size(); begin += kBatch) {
    const Batch batch(points_.data(), begin, std::min(begin + kBatch, uint32_t(points_.size())));
    const ShadowOrigins origins(batch.surfaces);
    for (uint32_t l = 0; l < luminaires_; ++l) light(runs, l, batch, origins);
  }
  queue_.flush();
  if (!dropped_.empty()) add_dropped();
  tally_.light.shadow_rays += queue_.traced() - traced_before;
}

/// The runs' camera rays; returns their number.
uint32_t SamplePacket::make_rays(std::span<const SampleRun> runs) {
  PixelSamples samples[kPacket];
  uint32_t lane = 0;
  for (size_t r = 0; r < runs.size(); ++r) {
    const SampleRun& run = runs[r];
    const uint64_t frame = frame_pixel(run.pixel);
    samples[r] = {frame_.area.x + run.pixel % frame_.block_width,
                  frame_.area.y + run.pixel / frame_.block_width,
                  {frame, run.first, run.count}};
    for (uint32_t i = 0; i < run.count; ++i) lanes_[lane++] = {run.pixel, run.first + i, frame, run.all};
  }
  c_.pixel_rays.make({samples, runs.size()}, rays_, dx, dy);
  tally_.primary_rays += lane;
  return lane;
}

void SamplePacket::look(std::span<const SampleRun> runs) {
  tally_.light.stop_if_cancelled();
  const uint32_t count = make_rays(runs);
  c_.geometry.intersect(rays_, (1u << count) - 1, hits);
}

/// Camera rays, and the surface points that they see.
void SamplePacket::find_points(std::span<const SampleRun> runs) {
  const uint32_t lane = make_rays(runs);
  std::fill_n(charge, lane, 0.0);
  std::fill_n(rays_of, lane, 0u);
  HitColumns found;
  c_.geometry.find_surfaces(rays_, lane, found);
  std::copy_n(found.hits, lane, hits);
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

/// A point of the luminaire for each surface point.
void SamplePacket::place_on_light(std::span<const SampleRun> runs, uint32_t luminaire, const Batch& batch,
                                  float* u, float* v) const {
  alignas(64) float lane_u[kPacket], lane_v[kPacket];
  SampleRange ranges[kPacket];
  uint32_t lane = 0;
  for (size_t r = 0; r < runs.size(); lane += runs[r++].count)
    ranges[r] = {hash_of(lanes_[lane].frame_pixel, luminaire * lobes_), runs[r].first, runs[r].count};
  c_.pixel_light_sampler.light({ranges, runs.size()}, lane_u, lane_v);
  for (uint32_t i = 0; i < batch.surfaces.count; ++i) {
    u[i] = lane_u[batch.lane[i]], v[i] = lane_v[batch.lane[i]];
    if (batch.bounce[i] == 0) continue;
    const Lane& at = lanes_[batch.lane[i]];
    const uint32_t slot = (batch.bounce[i] * luminaires_ + luminaire) * lobes_;
    const SampleRange one{hash_of(at.frame_pixel, slot), at.index, 1};
    c_.pixel_light_sampler.light({&one, 1}, u + i, v + i);
  }
}

/// First looks go everywhere, and where penumbra was found all samples do. At edges what lies between two
/// surfaces may hide luminaires from a part of the pixel that no sample has met yet: there another ray a
/// sample looks at one luminaire after the other.
bool SamplePacket::wants_ray(const Lane& lane, const Slot& slot, uint32_t luminaire) const {
  if (lane.index < kFirstSamples || lane.all || slot.uncertain) return true;
  return frame_.edge[lane.pixel] && (lane.index + luminaire) % luminaires_ == 0;
}

/// What one luminaire sends to the surface points.
void SamplePacket::light(std::span<const SampleRun> runs, uint32_t l, const Batch& batch,
                         const ShadowOrigins& origins) {
  const Luminaire& luminaire = c_.luminaires[l];
  const uint32_t count = batch.surfaces.count;
  alignas(64) double form_factors[kBatch];
  alignas(64) float u[kBatch], v[kBatch];
  LightPoints on_light;
  LambertColumns lambert;
  luminaire.form_factors(batch.surfaces, form_factors);
  place_on_light(runs, l, batch, u, v);
  luminaire.evaluate_each(batch.surfaces, u, v, on_light);
  reflect_diffusely(batch.albedo, count, luminaire.role().diffuse ? luminaire.radiance() : Vec3d{},
                    display_scale_, form_factors, on_light.form_factor, lambert);
  const ShadowRayColumns rays(origins, on_light.x, on_light.y, on_light.z);
  for (uint32_t i = 0; i < count; ++i) {
    const uint32_t lane = batch.lane[i];
    if (form_factors[i] <= 0) {
      ++tally_.light.decided_without_ray;
      continue;
    }
    const LitPoint& lit = points_[batch.begin + i];
    Reflected light{{lambert.red[i], lambert.green[i], lambert.blue[i]}, lambert.size[i], lambert.weight[i]};
    const float sampled = on_light.form_factor[i];
    const Vec3f to_light(on_light.x[i], on_light.y[i], on_light.z[i]);
    if (!batch.lambert[i]) light = reflected_by_lobes(lit, luminaire, form_factors[i], to_light, sampled);
    // Too dim for a ray.
    if (luminaires_ > 1 && !light.may_be_glossy && charge[lane] + light.size / 2 <= kDropShare * tolerance_) {
      charge[lane] += light.size / 2;
      ++tally_.light.decided_without_ray;
      dropped_.push_back({batch.begin + i, l, light.diffuse});
      continue;
    }
    const uint32_t s = (batch.bounce[i] * luminaires_ + l) * lobes_;
    const Slot* slot = &frame_.of_pixel(lanes_[lane].pixel)[s];
    if (slot->split) {
      light_by_packet(lit, l, form_factors[i], u[i], v[i], lane, s);
      continue;
    }
    const bool wanted = wants_ray(lanes_[lane], *slot, l) || (frame_.glossy && slot[1].uncertain);
    int32_t ray = SlotColumns::kNoRay;
    if (wanted && sampled > 0) {
      ray = int32_t(visible_.size());
      visible_.push_back(1);
      ++rays_of[lane];
      if (luminaire.casts_shadow()) queue_.add(rays, i, luminaire.shadow_kind(), visible_.back());
    }
    if (light.size > 0) columns_of(s).set(lane, light.diffuse, light.weight, ray);
    if (light.glossy_weight > 0)
      columns_of(s + 1).set(lane, light.glossy, max_abs(light.glossy) * display_scale_, ray);
  }
}

/// Of the luminaire's 4 x 4 cells one point each, at the sample's place (u, v) in its cell: the integrand
/// that remains in four dimensions varies far less than that of one point.
void SamplePacket::light_by_packet(const LitPoint& lit, uint32_t l, double form_factor, float u, float v,
                                   uint32_t lane, uint32_t s) {
  constexpr uint32_t kCells = 4;
  static_assert(kCells * kCells == kPacket);
  const Luminaire& luminaire = c_.luminaires[l];
  alignas(64) float cell_u[kPacket], cell_v[kPacket];
  constexpr float kBelow1 = 0x1.fffffep-1f;  // sums are rounded up to 1
  for (uint32_t k = 0; k < kPacket; ++k) {
    cell_u[k] = std::min((float(k % kCells) + u) / kCells, kBelow1);
    cell_v[k] = std::min((float(k / kCells) + v) / kCells, kBelow1);
  }
  const ShadingPoint shading(lit.surface, *lit.material, lit.ray_direction);
  LightBatch points;
  const uint32_t rays = points.trace(shading, luminaire, {c_.geometry, lit.surface, luminaire.shadow_kind()},
                                     cell_u, cell_v, kPacket);
  tally_.light.shadow_rays += rays;
  rays_of[lane] += rays;
  const auto sum = [](const float* values) { return std::accumulate(values, values + kPacket, 0.0); };
  const Vec3d arriving = lit.throughput * luminaire.radiance();
  if (luminaire.role().diffuse) {
    const DiffuseColour colour = diffuse_colour(shading, luminaire);
    const Vec3d diffuse = arriving * colour.mean * form_factor;
    const double size = max_abs(diffuse) * display_scale_, all = sum(points.diffuse);
    if (size > 0)
      columns_of(s).set(lane, diffuse, size * all / (kPacket * form_factor * colour.weight),
                        all > 0 ? SlotColumns::kRays : SlotColumns::kNoRay,
                        all > 0 ? sum(points.seen_diffuse) / all : 0);
  }
  if (!shading.has_glossy || !luminaire.role().glossy) return;
  // No closed form: the points' mean itself stands for the unshadowed value.
  Reflection lobe;
  add_reflection(shading, points.points.x, points.points.y, points.points.z, points.points.form_factor,
                 kPacket, lobe);
  if (lobe.weight <= 0) return;
  const Vec3d glossy = arriving * lobe.glossy_of(*lit.material) / kPacket;
  const double all = sum(points.glossy);
  columns_of(s + 1).set(lane, glossy, max_abs(glossy) * display_scale_, SlotColumns::kRays,
                        all > 0 ? sum(points.seen_glossy) / all : 0);
}

/// The same as LambertColumns have, where there is more.
SamplePacket::Reflected SamplePacket::reflected_by_lobes(const LitPoint& lit, const Luminaire& luminaire,
                                                         double form_factor, const Vec3f& to_light,
                                                         float sampled) const {
  const ShadingPoint shading(lit.surface, *lit.material, lit.ray_direction);
  const Vec3d arriving = lit.throughput * luminaire.radiance();
  const DiffuseColour colour = diffuse_colour(shading, luminaire);
  Reflected light{arriving * colour.mean * form_factor};
  light.size = max_abs(light.diffuse) * display_scale_;
  float weight = sampled;
  weigh_diffuse(shading, &to_light.x, &to_light.y, &to_light.z, 1, &weight);
  light.weight = light.size * double(weight) / (form_factor * colour.weight);
  light.may_be_glossy = shading.has_glossy;
  if (!shading.has_glossy || !luminaire.role().glossy) return light;
  // No closed form: the sampled value itself stands for the unshadowed one.
  Reflection lobe;
  add_reflection(shading, &to_light.x, &to_light.y, &to_light.z, &sampled, 1, lobe);
  light.glossy = arriving * lobe.glossy_of(*lit.material);
  light.glossy_weight = lobe.weight;
  return light;
}

Vec3d SamplePacket::value(uint32_t lane) const {
  Vec3d sum = ends[lane].background;
  for (const SlotColumns& column : contributions_) {
    if (column.arrives(lane)) sum += column.unshadowed.get(lane) * visible(column, lane);
  }
  return sum;
}

/// A sample sees of the dropped luminaires what it sees of the others.
void SamplePacket::add_dropped() {
  double lit[kPacket] = {}, dark[kPacket] = {};
  for (const SlotColumns& column : contributions_)
    for (uint32_t lane = 0; lane < kPacket; ++lane) {
      if (!column.arrives(lane)) continue;
      const double share = visible(column, lane);
      lit[lane] += share;
      dark[lane] += 1 - share;
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
