// SPDX-License-Identifier: GPL-3.0-or-later
#include "lighting/bounded_refine.h"

#include <algorithm>
#include <unordered_map>

#include "lighting/pooled_error.h"

namespace penumbra {
namespace {

/// Pixels to each side whose differences are pooled (evidence: 5x5 is best), cut at the tile's edge so that a
/// tile needs nothing of the next one.
constexpr int kPool = 2;

}  // namespace

TileItems::TileItems(const std::vector<BoundedItem*>& items, const std::vector<LitPoint>& points,
                     const Block& block)
    : points_(points), block_(block) {
  for (const BoundedItem* item : items)
    if (slots_.empty() || slots_.back() != slot(*item)) slots_.push_back(slot(*item));
  std::sort(slots_.begin(), slots_.end());
  slots_.erase(std::unique(slots_.begin(), slots_.end()), slots_.end());
  known_.resize(slots_.size() * kTile * kTile);
  for (const BoundedItem* item : items) update(*item);
}

TileItems::Place TileItems::place(const BoundedItem& item) const {
  const uint32_t p = points_[item.point].pixel;
  return {int((p % block_.width - block_.core_x) % kTile), int((p / block_.width - block_.core_y) % kTile)};
}

size_t TileItems::index(const BoundedItem& item) const {
  const auto s = size_t(std::lower_bound(slots_.begin(), slots_.end(), slot(item)) - slots_.begin());
  const Place at = place(item);
  return (s * kTile + size_t(at.y)) * kTile + size_t(at.x);
}

template <typename Function>
void TileItems::for_neighbours(const BoundedItem& item, int reach, Function function) const {
  const size_t own = index(item);
  const int x = int(own % kTile), y = int(own / kTile % kTile), last = int(kTile) - 1;
  const Known* slot = &known_[own - own % (kTile * kTile)];
  for (int j = std::max(y - reach, 0); j <= std::min(y + reach, last); ++j)
    for (int i = std::max(x - reach, 0); i <= std::min(x + reach, last); ++i) {
      const Known& known = slot[j * int(kTile) + i];
      if (known.count > 0) function(known.count, known.variance);
    }
}

TileRefiner::TileRefiner(const ItemSampler& sampler, const std::vector<LitPoint>& points, const Block& block,
                         const BoundedSettings& settings)
    : sampler_(sampler), points_(points), block_(block), settings_(settings) {}

double TileRefiner::error(const BoundedItem& item, const TileItems& items) const {
  if (item.facing == 0) return item.size();  // all points below the horizon tell nothing
  // Where a luminaire is mostly below it, only the points above count as points.
  const double n = item.count, p = (item.lit + 1.0) / (item.facing + 2.0);
  const double smoothed =
      kItemCalibration.smoothed * item.size() * std::sqrt(p * (1 - p)) * std::pow(item.facing, -0.75);
  PooledVariance pooled(smoothed * smoothed, kItemCalibration.prior_weight);
  items.for_neighbours(item, kPool, [&](uint32_t count, double variance) {
    if (count >= kPacket) pooled.add(variance, count / n, 1.5);
  });
  return std::sqrt(pooled.mean());
}

void TileRefiner::refine(std::vector<BoundedItem*>& items, std::vector<PixelLight>& pixels,
                         LightTally& tally) const {
  std::unordered_map<uint32_t, std::vector<BoundedItem*>> by_pixel;
  for (BoundedItem* item : items) {
    by_pixel[points_[item->point].pixel].push_back(item);
    if (item->count == 0) sampler_.advance(*item, next_level(0), tally);
  }
  TileItems tile(items, points_, block_);
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
        const double e = error(*item, tile);
        errors.emplace_back(item, e);
        variance += e * e;
        radiance += item->radiance();
      }
      const double charged = pixels[pixel].error;
      const double tolerance =
          settings_.tolerance * std::max(1.0, max_component(radiance) * settings_.display_scale);
      const double allowed = std::max(tolerance - charged, 0.25 * tolerance) / kItemCalibration.stop;
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
      pixels[pixel].error = charged + kItemCalibration.report * std::sqrt(variance);
      own.clear();
    }
    for (BoundedItem* item : to_advance) {
      sampler_.advance(*item, next_level(item->count), tally);
      tile.update(*item);
      again = true;
    }
  }
}

}  // namespace penumbra
