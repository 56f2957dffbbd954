// SPDX-License-Identifier: GPL-3.0-or-later
#include "lighting/bounded_refine.h"

#include <algorithm>
#include <unordered_map>

#include "sampling/hash.h"
#include "visibility/shadow_rays.h"

namespace penumbra {
namespace {

/// Pixels to each side whose differences are pooled (evidence: 5x5 is best), cut at the tile's edge so that a
/// tile needs nothing of the next one.
constexpr int kPool = 2;

/// B blocks of n / B points overstate the variance of the whole by B to this power: 3/2 for an edge through
/// the luminaire (Owen-scrambled nets), 1 for independent points; foliage lies between.
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
  return squares / (blocks - 1) / std::pow(blocks, kBlockExponent);
}

}  // namespace

StreamKey ItemSampler::key(const BoundedItem& item) const {
  const uint64_t index = points_[item.point].stream * luminaires_.size() + item.luminaire;
  return {index, hash_of(index)};
}

void ItemSampler::advance(BoundedItem& item, uint32_t target, LightTally& tally) const {
  const LitPoint& lit = points_[item.point];
  const Luminaire& luminaire = luminaires_[item.luminaire];
  const ShadingPoint point(lit.surface, *lit.material, lit.ray_direction);
  const ShadowRays rays(geometry_, lit.surface);
  alignas(64) float u[kPacket], v[kPacket], unshadowed[kPacket], phong[kPacket], visible_phong[kPacket];
  alignas(64) int traced[kPacket] = {};
  LightPoints points;
  for (; item.count < target; item.count += kPacket) {
    sampler_.points(key(item), item.count, kPacket, u, v);
    luminaire.evaluate(lit.surface, u, v, kPacket, points);
    float* f = points.form_factor;
    std::copy(f, f + kPacket, unshadowed);
    // The first look's rays are known already.
    float known[kFirstLook];
    if (item.count == 0) {
      for (uint32_t i = 0; i < kFirstLook; ++i) {
        known[i] = item.first_lit >> i & 1 ? f[i] : 0.0f;
        f[i] = 0;
      }
    }
    if (luminaire.casts_shadow()) tally.shadow_rays += rays.hide(points.x, points.y, points.z, f, traced);
    if (item.count == 0) std::copy(known, known + kFirstLook, f);
    if (point.has_phong) {
      evaluate_phong(point, points.x, points.y, points.z, unshadowed, kPacket, phong);
      evaluate_phong(point, points.x, points.y, points.z, f, kPacket, visible_phong);
    }
    for (uint32_t i = 0; i < kPacket; ++i) {
      if (item.count == 0 && i == kPacket / 2) item.at_power = item.sums;  // halves of the first packet
      item.sums.f += double(unshadowed[i]);
      item.sums.fv += double(f[i]);
      item.facing += unshadowed[i] > 0;
      item.lit += f[i] > 0;
      if (point.has_phong) {
        item.sums.p += double(phong[i]);
        item.sums.pv += double(visible_phong[i]);
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

TileRefiner::TileRefiner(const ItemSampler& sampler, const std::vector<LitPoint>& points, const Block& block,
                         const BoundedSettings& settings)
    : sampler_(sampler), points_(points), block_(block), settings_(settings) {}

double TileRefiner::error(const BoundedItem& item, const std::vector<BoundedItem*>& items) const {
  const double n = item.count, p = (item.lit + 1.0) / (item.facing + 2.0);
  const double smoothed = calibration_.smoothed * item.size() * std::sqrt(p * (1 - p)) * std::pow(n, -0.75);
  const LitPoint& at = points_[item.point];
  const int x = int(at.pixel % block_.width), y = int(at.pixel / block_.width);
  double sum = 0;
  int count = 0;
  for (const BoundedItem* other : items) {
    const LitPoint& there = points_[other->point];
    if (other->luminaire != item.luminaire || there.bounce != at.bounce || other->count < 16) continue;
    const int dx = int(there.pixel % block_.width) - x, dy = int(there.pixel / block_.width) - y;
    if (std::abs(dx) > kPool || std::abs(dy) > kPool) continue;
    sum += other->variance * std::pow(other->count / n, 1.5);
    ++count;
  }
  return std::sqrt((calibration_.prior_weight * smoothed * smoothed + sum) /
                   (calibration_.prior_weight + count));
}

void TileRefiner::refine(std::vector<BoundedItem*>& items, std::vector<PixelLight>& pixels,
                         LightTally& tally) const {
  std::unordered_map<uint32_t, std::vector<BoundedItem*>> by_pixel;
  for (BoundedItem* item : items) {
    by_pixel[points_[item->point].pixel].push_back(item);
    if (item->count == 0) sampler_.advance(*item, next_level(0), tally);
  }
  std::vector<std::pair<BoundedItem*, double>> errors;
  bool again = true;
  while (again) {
    again = false;
    std::vector<BoundedItem*> to_advance;
    for (auto& [pixel, own] : by_pixel) {
      if (own.empty()) continue;
      double variance = 0;
      Vec3d radiance = pixels[pixel].radiance;
      errors.clear();
      for (BoundedItem* item : own) {
        const double e = error(*item, items);
        errors.emplace_back(item, e);
        variance += e * e;
        radiance += item->radiance();
      }
      const double charged = pixels[pixel].error;
      const double tolerance =
          settings_.tolerance * std::max(1.0, max_component(radiance) * settings_.display_scale);
      const double allowed = std::max(tolerance - charged, 0.25 * tolerance) / calibration_.stop;
      bool done = variance <= allowed * allowed;
      if (!done) {
        bool can = false;
        for (auto& [item, e] : errors) {
          if (e * e <= allowed * allowed / double(own.size())) continue;
          if (next_level(item->count) > settings_.max_light_samples) continue;
          to_advance.push_back(item);
          can = true;
        }
        if (!can) {
          pixels[pixel].at_limit = true;
          done = true;
        }
      }
      if (!done) continue;
      pixels[pixel].radiance = radiance;
      pixels[pixel].error = charged + calibration_.report * std::sqrt(variance);
      own.clear();
    }
    for (BoundedItem* item : to_advance) {
      sampler_.advance(*item, next_level(item->count), tally);
      again = true;
    }
  }
}

}  // namespace penumbra
