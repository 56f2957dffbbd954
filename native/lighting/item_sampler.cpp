// SPDX-License-Identifier: GPL-3.0-or-later
#include "lighting/item_sampler.h"

#include <algorithm>

#include "lighting/light_batch.h"
#include "lighting/lobe_colours.h"
#include "lighting/pooled_error.h"
#include "sampling/hash.h"

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

}  // namespace penumbra
