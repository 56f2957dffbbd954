// SPDX-License-Identifier: GPL-3.0-or-later
#include "lighting/bounded_refine.h"

#include <algorithm>
#include <unordered_map>

namespace penumbra {
namespace {

/// Pixels to each side whose differences are pooled (evidence: 5x5 is best), cut at the tile's edge so that a
/// tile needs nothing of the next one.
constexpr int kPool = 2;

}  // namespace

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
