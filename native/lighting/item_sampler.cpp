// SPDX-License-Identifier: GPL-3.0-or-later
#include "lighting/item_sampler.h"

#include <algorithm>
#include <cmath>

#include "lighting/light_batch.h"
#include "lighting/lobe_colours.h"
#include "lighting/pooled_error.h"
#include "sampling/hash.h"
#include "visibility/chords.h"

namespace penumbra {
namespace {

/// Points for unshadowed glossy lobes, which have no closed form: shading only, no rays.
constexpr uint32_t kGlossyPoints = 1024;

/// Of share_of_blocks: foliage lies between an edge and independent points.
constexpr double kBlockExponent = 1.35;

/// Estimates of blocks of equal size, from the sums at their ends, tell the variance of the whole.
double block_variance(const BoundedItem& item) {
  double values[3];
  int blocks = 2;
  const bool power_of_two = (item.count & (item.count - 1)) == 0;
  if (power_of_two) {
    values[0] = item.display(item.at_power);
    values[1] = item.display(item.sums - item.at_power);
  } else {
    values[0] = item.display(item.at_half);
    values[1] = item.display(item.at_power - item.at_half);
    values[2] = item.display(item.sums - item.at_power);
    blocks = 3;
  }
  double mean = 0, squares = 0;
  for (int i = 0; i < blocks; ++i) mean += values[i] / blocks;
  for (int i = 0; i < blocks; ++i) squares += (values[i] - mean) * (values[i] - mean);
  return squares * share_of_blocks(blocks, kBlockExponent);
}

/// Whole groups from `begin` on, as many as a packet's items hold; of a larger one its next items.
size_t end_of_groups(std::span<const uint32_t> group, size_t begin) {
  const size_t most = begin + kPacket;
  if (most >= group.size()) return group.size();
  size_t end = most;
  while (end > begin && group[end - 1] == group[end]) --end;
  return end > begin ? end : most;
}

float fraction(float x) {
  return x - std::floor(x);
}

/// As Chords::sum(), of any number; of many, only the sums of even and odd ones are apart.
std::optional<std::array<ChordSums, 4>> sum_lines(Chords& chords, uint32_t count, float offset,
                                                  const LightTally& tally) {
  if (count <= Chords::kMost) return chords.sum(count, offset);
  std::array<ChordSums, 4> sums;
  const uint32_t sets = count / Chords::kMost;
  for (uint32_t i = 0; i < sets; ++i) {
    tally.stop_if_cancelled();
    const auto set = chords.sum(Chords::kMost, (offset + float(i)) / float(sets));
    if (!set) return std::nullopt;
    for (const ChordSums& part : *set) sums[i % 2] = sums[i % 2] + part;
  }
  return sums;
}

}  // namespace

StreamKey ItemSampler::key(const LookedItem& item) const {
  const uint64_t index = points_[item.point].stream * luminaires_.size() + item.luminaire;
  return {index, hash_of(index)};
}

LookedItem ItemSampler::make(uint32_t point, uint32_t luminaire, double form_factor) const {
  const LitPoint& lit = points_[point];
  LookedItem item;
  item.point = point;
  item.pixel = lit.pixel;
  item.luminaire = luminaire;
  const Vec3d arriving = lit.throughput * luminaires_[luminaire].radiance();
  const ShadingPoint shading(lit.surface, *lit.material, lit.ray_direction);
  const Vec3d diffuse = arriving * diffuse_colour(shading, luminaires_[luminaire]).mean * form_factor;
  Vec3d phong;
  if (shading.has_glossy && luminaires_[luminaire].role().glossy)
    phong = unshadowed_glossy(shading, arriving, luminaires_[luminaire], key(item));
  item.set_light(diffuse, phong, settings_.display_scale);
  return item;
}

Vec3d ItemSampler::unshadowed_glossy(const ShadingPoint& point, const Vec3d& arriving,
                                     const Luminaire& luminaire, const StreamKey& key) const {
  alignas(64) float u[kBatch], v[kBatch];
  LightPoints points;
  Reflection sum;
  const uint32_t count = std::min(kGlossyPoints, settings_.max_light_samples / kPacket * kPacket);
  for (uint32_t first = 0; first < count; first += kBatch) {
    const uint32_t n = std::min(kBatch, count - first);
    sampler_.points(key, first, n, u, v);
    luminaire.evaluate(point.surface, u, v, n, points);
    add_reflection(point, points.x, points.y, points.z, points.form_factor, n, sum);
  }
  return arriving * sum.glossy_of(point.material) / count;
}

void ItemSampler::look(std::span<LookedItem> items, std::span<const uint32_t> group,
                       LightTally& tally) const {
  const Luminaire& luminaire = luminaires_[items.front().luminaire];
  const uint32_t looks = luminaire.is_point() ? 1 : items.front().looks;
  for (size_t begin = 0, end; begin < items.size(); begin = end) {
    end = end_of_groups(group, begin);
    look_at_packets(items.subspan(begin, end - begin), &group[begin], luminaire, looks, tally);
  }
}

static_assert(kFirstLook <= kMostPoints && kFirstLook * kPacket <= kBatch);

/// At most kPacket items.
void ItemSampler::look_at_packets(std::span<LookedItem> items, const uint32_t* group,
                                  const Luminaire& luminaire, uint32_t looks, LightTally& tally) const {
  tally.stop_if_cancelled();
  alignas(64) float u[kBatch], v[kBatch], unshadowed[kBatch];
  StreamKey keys[kPacket];
  SurfaceColumns surfaces;
  LightPoints points;
  const auto count = uint32_t(items.size());
  for (uint32_t i = 0; i < count; ++i) {
    surfaces.add(points_[items[i].point].surface);
    keys[i] = key(items[i]);
  }
  sampler_.first_points({keys, count}, looks, u, v);
  luminaire.evaluate_each(surfaces, u, v, points, looks);
  const float* f = points.form_factor;
  std::copy(f, f + looks * count, unshadowed);
  if (luminaire.casts_shadow())
    tally.shadow_rays += hide_from_each(geometry_, surfaces, group, luminaire.shadow_kind(), looks, points.x,
                                        points.y, points.z, points.form_factor);
  for (uint32_t i = 0; i < count; ++i) {
    // Behind a transparent surface a point is both.
    for (uint32_t k = 0; k < looks; ++k) {
      items[i].first_lit |= uint8_t((f[k * count + i] > 0) << k);
      items[i].first_dark |= uint8_t((f[k * count + i] < unshadowed[k * count + i]) << k);
    }
    items[i].looked = true;
  }
}

void ItemSampler::advance(BoundedItem& item, uint32_t target, LightTally& tally) const {
  const LitPoint& lit = points_[item.point];
  const Luminaire& luminaire = luminaires_[item.luminaire];
  const ShadingPoint point(lit.surface, *lit.material, lit.ray_direction);
  const ShadowRays rays(geometry_, lit.surface, luminaire.shadow_kind());
  alignas(64) float u[kBatch], v[kBatch];
  LightBatch points;
  for (uint32_t n; item.count < target; item.count += n) {
    n = std::min(kBatch, target - item.count);
    tally.stop_if_cancelled();
    sampler_.points(key(item), item.count, n, u, v);
    KnownPoints known;  // by the first look
    if (item.count == 0 && item.looked) known = {item.first_lit, item.first_dark};
    tally.shadow_rays += points.trace(point, luminaire, rays, u, v, n, known);
    for (uint32_t i = 0; i < n; ++i) {
      if (item.count == 0 && i == kPacket / 2) item.at_power = item.sums;  // halves of the first packet
      item.sums.f += double(points.diffuse[i]);
      item.sums.fv += double(points.seen_diffuse[i]);
      item.facing += points.diffuse[i] > 0;
      item.lit += points.seen_diffuse[i] > 0;
      if (point.has_glossy) {
        item.sums.p += double(points.glossy[i]);
        item.sums.pv += double(points.seen_glossy[i]);
      }
    }
  }
  item.variance = block_variance(item);
  const bool power_of_two = (item.count & (item.count - 1)) == 0;
  if (power_of_two) {
    item.at_half = item.at_power;
    item.at_power = item.sums;
  }
}

bool ItemSampler::may_use_lines(const BoundedItem& item) const {
  const Luminaire& luminaire = luminaires_[item.luminaire];
  const Closures& material = *points_[item.point].material;
  return settings_.lines && !item.never_lines && !material.has_glossy() && !material.has_diffuse_lobes &&
         luminaire.casts_shadow() && luminaire.shadow_kind().mask == kShadowRay &&
         luminaire.emitter().parallelogram() && geometry_.occluders();
}

LinesTaken ItemSampler::advance_lines(BoundedItem& item, uint32_t lines, uint32_t most, Chords& chords,
                                      LightTally& tally) const {
  tally.stop_if_cancelled();
  const auto luminaire = luminaires_[item.luminaire].emitter().parallelogram();
  alignas(64) float u[kPacket], v[kPacket];
  sampler_.points(key(item), 0, kPacket, u, v);
  // A direction of its own for each: an edge along it is seldom seen so by neighbours, too.
  const auto view = LuminaireView::from(points_[item.point].surface, *luminaire, v[0]);
  if (!view) return LinesTaken::kUnfit;
  if (!chords.look(*geometry_.occluders(), *view, most)) return LinesTaken::kTooDear;
  const auto half = [](const ChordSums& a, const ChordSums& b) {
    return VisibilitySums{a.all + b.all, a.seen + b.seen, 0, 0};
  };
  // Estimates of the variance of half of the lines, by a pair of halves that interleave.
  const auto of_pair = [&](const VisibilitySums& a, const VisibilitySums& b) {
    const double difference = item.display(a) - item.display(b);
    return difference * difference / 2;
  };
  const bool first = item.lines == 0;
  float offset = first ? u[0] : item.line_offset;
  // At first all of them, then as many again, half way between those that are there.
  const auto sums =
      sum_lines(chords, first ? lines : lines / 2, first ? offset : fraction(offset + 0.5f), tally);
  if (!sums) return LinesTaken::kUnfit;
  const auto& [a, b, c, d] = *sums;
  const VisibilitySums even = half(a, c), odd = half(b, d), added = even + odd;
  if (first) {
    item.half_variance = of_pair(even, odd);
    item.quarter_variance = (of_pair(half(a, {}), half(c, {})) + of_pair(half(b, {}), half(d, {}))) / 2;
    item.sums = added;
  } else {
    item.quarter_variance = (item.half_variance + of_pair(even, odd)) / 2;
    item.half_variance = of_pair(item.sums, added);
    item.sums = item.sums + added;
    offset = fraction(2 * offset);
  }
  item.line_offset = offset;
  tally.light_lines += lines - item.lines;
  item.lines = lines;
  return LinesTaken::kYes;
}

}  // namespace penumbra
