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

/// 32 lines take less time than n points where less than this number of triangles may be in the way, n = 8
/// sqrt(triangles) + triangles / 10 (tests/benchmarks/README.md): among leaves, wires, solid and finely
/// tessellated objects alike, within a factor of 2.
double most_occluders(double points) {
  const double root = std::sqrt(1600 + 10 * points) - 40;
  return root * root;
}
/// A line counts as so many points where their number is limited: their error is the same.
constexpr uint32_t kPointsOfLine = 16;
/// The first lines.
constexpr uint32_t kFirstLines = 32;
/// They are tried where so many points are wanted, and with twice as many at once where it is many.
constexpr double kLeastWanted = 64, kManyWanted = 1000;

/// How much smaller a variance may be expected to be by twice as many lines: as for an edge that bends; where
/// all differ.
constexpr double kLeastGain = 1.0 / 8, kMostGain = 0.5;

/// What neighbours tell of variances, beside what an item's own lines do, in the bound that is reported.
constexpr double kPooledShare = 0.46;

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
      if (known.count > 0 && known.lines == (item.lines > 0)) function(known);
    }
}

TileRefiner::TileRefiner(const ItemSampler& sampler, const std::vector<LitPoint>& points, const Block& block,
                         const BoundedSettings& settings)
    : sampler_(sampler), points_(points), block_(block), settings_(settings) {}

TileRefiner::Error TileRefiner::error(const BoundedItem& item, const TileItems& items) const {
  if (item.lines > 0) return line_error(item, items);
  const auto by_points = [](double e) { return Error{e, kItemCalibration.report * e}; };
  if (item.facing == 0) return by_points(item.size());  // all points below the horizon tell nothing
  // Where a luminaire is mostly below it, only the points above count as points.
  const double n = item.count, p = (item.lit + 1.0) / (item.facing + 2.0);
  const double smoothed =
      kItemCalibration.smoothed * item.size() * std::sqrt(p * (1 - p)) * std::pow(item.facing, -0.75);
  PooledVariance pooled(smoothed * smoothed, kItemCalibration.prior_weight);
  items.for_neighbours(item, kPool, [&](const TileItems::Known& known) {
    if (known.count >= kPacket) pooled.add(known.variance, known.count / n, 1.5);
  });
  return by_points(std::sqrt(pooled.mean()));
}

/// How much smaller the variance is by half of the lines than by a quarter tells how much smaller it is by
/// all.
TileRefiner::Error TileRefiner::line_error(const BoundedItem& item, const TileItems& items) const {
  const double n = item.lines, seen = item.sums.f > 0 ? item.sums.fv / item.sums.f : 0,
               p = (n * seen + 1) / (n + 2);
  const double smoothed =
      kLineCalibration.smoothed * item.size() * std::sqrt(p * (1 - p)) * std::pow(n, -1.5);
  PooledVariance halves(0, 0), quarters(0, 0);
  uint32_t neighbours = 0;
  items.for_neighbours(item, kPool, [&](const TileItems::Known& known) {
    halves.add(known.variance, known.count / n, 3.0);
    quarters.add(known.quarter_variance, known.count / n, 3.0);
    ++neighbours;
  });
  const double gain =
      quarters.mean() > 0 ? std::clamp(halves.mean() / quarters.mean(), kLeastGain, kMostGain) : kMostGain;
  const double prior = kLineCalibration.prior_weight;
  const double pooled =
      (prior * smoothed * smoothed + neighbours * gain * halves.mean()) / (prior + neighbours);
  // Whatever neighbours tell: an edge along the lines is one item's alone.
  const double own = gain * item.half_variance;
  return {std::sqrt(std::max(pooled, own)), kLineCalibration.report * std::sqrt(kPooledShare * pooled + own)};
}

bool TileRefiner::can_advance(const BoundedItem& item) const {
  if (item.lines == 0) return next_level(item.count) <= settings_.max_light_samples;
  return 2 * item.lines <= settings_.max_light_samples / kPointsOfLine;
}

/// points_wanted: what points alone would probably take.
void TileRefiner::advance(BoundedItem& item, double points_wanted, LineSearch& search,
                          LightTally& tally) const {
  if (item.lines > 0) {
    if (sampler_.advance_lines(item, 2 * item.lines, ~0u, search.chords, tally) == LinesTaken::kYes) return;
    BoundedItem again{LookedItem(item)};
    again.never_lines = true;
    sampler_.advance(again, item.count, tally);
    item = again;
  }
  const double wanted = std::min(points_wanted, double(settings_.max_light_samples));
  if (wanted >= kLeastWanted && kFirstLines * kPointsOfLine <= settings_.max_light_samples &&
      sampler_.may_use_lines(item)) {
    const auto most = uint32_t(most_occluders(wanted));
    if (most / 2 >= search.refused) {
      const uint32_t lines = wanted < kManyWanted ? kFirstLines : 2 * kFirstLines;
      switch (sampler_.advance_lines(item, lines, most, search.chords, tally)) {
        case LinesTaken::kYes:
          return;
        case LinesTaken::kTooDear:
          search.refused = std::max(search.refused, most);
          break;
        case LinesTaken::kUnfit:
          item.never_lines = true;
      }
    }
  }
  sampler_.advance(item, next_level(item.count), tally);
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
  LineSearch search;
  bool again = true;
  while (again) {
    again = false;
    std::vector<std::pair<BoundedItem*, double>> to_advance;  // and the points that it probably takes
    for (auto& [pixel, own] : by_pixel) {
      if (own.empty()) continue;
      double variance = 0, reported = 0;
      Vec3d radiance = pixels[pixel].radiance;
      errors.clear();
      for (BoundedItem* item : own) {
        const Error e = error(*item, tile);
        errors.emplace_back(item, e.standard);
        variance += e.standard * e.standard;
        reported += e.report * e.report;
        radiance += item->radiance();
      }
      const double charged = pixels[pixel].error;
      const double tolerance =
          settings_.tolerance * std::max(1.0, max_component(radiance) * settings_.display_scale);
      const double noise = pixels[pixel].noise_share;
      const double allowed =
          std::max(tolerance - charged, 0.25 * tolerance) / (kItemCalibration.stop * noise);
      bool done = variance <= allowed * allowed;
      if (!done) {
        bool can = false;
        for (auto& [item, e] : errors) {
          const double share = allowed / std::sqrt(double(own.size()));
          if (e <= share || !can_advance(*item)) continue;
          to_advance.emplace_back(item, item->count * std::pow(e / share, 4.0 / 3));
          can = true;
        }
        if (!can) {
          pixels[pixel].at_limit = true;
          done = true;
        }
      }
      if (!done) continue;
      pixels[pixel].radiance = radiance;
      pixels[pixel].error = charged + noise * std::sqrt(reported);
      own.clear();
    }
    std::sort(to_advance.begin(), to_advance.end(),
              [&](const auto& a, const auto& b) { return tile.index(*a.first) < tile.index(*b.first); });
    for (auto& [item, points] : to_advance) {
      advance(*item, points, search, tally);
      tile.update(*item);
      again = true;
    }
  }
}

}  // namespace penumbra
