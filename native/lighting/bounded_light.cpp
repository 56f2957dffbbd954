// SPDX-License-Identifier: GPL-3.0-or-later
#include "lighting/bounded_light.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "lighting/bounded_refine.h"
#include "lighting/light_parts.h"
#include "lighting/pooled_error.h"
#include "lighting/spread.h"

namespace penumbra {
namespace {

/// The gate looks at pixels this far to each side; the flood carries what refining found as far again.
constexpr int kGateReach = 3, kFloodReach = 2;
constexpr uint32_t kHalo = kGateReach + kFloodReach;

/// Share of a pixel's tolerance that dim luminaires may be charged for being dropped.
constexpr double kDropShare = 0.25;

enum Seen : uint8_t { kLit = 1, kDark = 2 };

/// The light of one block, step by step.
class BlockLight {
 public:
  BlockLight(const Block& block, const Geometry& geometry, std::span<const Luminaire> luminaires,
             const Sampler& sampler, const BoundedSettings& settings, const std::vector<LitPoint>& points,
             std::vector<PixelLight>& out, LightTally& tally, LightParts* parts, BlockMemory& memory)
      : block_(block),
        luminaires_(luminaires),
        settings_(settings),
        points_(points),
        out_(out),
        tally_(tally),
        parts_(parts),
        item_sampler_(geometry, luminaires, sampler, points, settings),
        memory_(memory),
        items_(memory),
        dropped_(memory),
        certain_error_(memory, block.pixels(), 0.0) {}

  void run() {
    find_items();
    drop_dim_items();
    first_look();
    add_dropped_items();
    gate();
    flood();
    settle_certain_items();
    refine_tiles();
    if (parts_)
      for (const BoundedItem& item : items_) add_parts(item);
    if (tally_.trace)
      for (const BoundedItem& item : items_) tally_.trace->add(pixel(item), decision(item));
  }

 private:
  /// Items of one bounce and one luminaire are compared with each other: a slot.
  size_t slot(const BoundedItem& item) const {
    return points_[item.point].bounce * luminaires_.size() + item.luminaire;
  }
  uint32_t pixel(const BoundedItem& item) const { return points_[item.point].pixel; }
  bool in_core(uint32_t pixel, int margin) const {
    const int x = int(pixel % block_.width) - int(block_.core_x),
              y = int(pixel / block_.width) - int(block_.core_y);
    return x >= -margin && y >= -margin && x < int(block_.core_width) + margin &&
           y < int(block_.core_height) + margin;
  }

  LightDecision decision(const BoundedItem& item) const {
    return {points_[item.point].bounce, item.luminaire,
            item.uncertain   ? "may be in penumbra"
            : item.first_lit ? "wholly seen"
                             : "wholly hidden",
            item.uncertain ? item.count : kFirstLook,
            item.uncertain   ? item.radiance()
            : item.first_lit ? item.unshadowed()
                             : Vec3d{}};
  }
  void find_items();
  void drop_dim_items();
  void add_dropped_items();
  void first_look();
  void gate();
  void flood();
  void settle_certain_items();
  void refine_tiles();
  void add_parts(const BoundedItem& item);

  const Block& block_;
  std::span<const Luminaire> luminaires_;
  const BoundedSettings& settings_;
  const std::vector<LitPoint>& points_;
  std::vector<PixelLight>& out_;
  LightTally& tally_;
  LightParts* parts_;
  ItemSampler item_sampler_;
  BlockMemory& memory_;
  Reused<BoundedItem> items_;     // by slot, then pixel
  Reused<BoundedItem> dropped_;   // too dim for a ray, by pixel
  Reused<double> certain_error_;  // of each pixel's certain items, display units
};

void BlockLight::find_items() {
  items_.reserve(points_.size());
  for (uint32_t l = 0; l < luminaires_.size(); ++l) {
    const Luminaire& luminaire = luminaires_[l];
    for (uint32_t begin = 0; begin < points_.size(); begin += kBatch) {
      const uint32_t end = std::min(begin + kBatch, uint32_t(points_.size()));
      SurfaceColumns columns;
      for (uint32_t p = begin; p < end; ++p) columns.add(points_[p].surface);
      alignas(64) double form_factors[kBatch];
      luminaire.form_factors(columns, form_factors);
      for (uint32_t p = begin; p < end; ++p) {
        tally_.stop_if_cancelled();
        if (form_factors[p - begin] <= 0) {
          tally_.decided_without_ray += in_core(points_[p].pixel, 0);
          continue;
        }
        const BoundedItem item = item_sampler_.make(p, l, form_factors[p - begin]);
        if (item.size() > 0) items_.push_back(item);
      }
    }
  }
  const auto before = [this](const BoundedItem& a, const BoundedItem& b) { return slot(a) < slot(b); };
  // Without mirrors they are in order already.
  if (!std::is_sorted(items_.begin(), items_.end(), before))
    std::stable_sort(items_.begin(), items_.end(), before);
}

/// Sets a pixel's dimmest items aside, as many as its share of the tolerance pays for: they get no ray.
void BlockLight::drop_dim_items() {
  if (luminaires_.size() < 2) return;
  std::vector<std::vector<uint32_t>> of_pixel(block_.pixels());
  for (uint32_t i = 0; i < items_.size(); ++i) of_pixel[pixel(items_[i])].push_back(i);
  std::vector<bool> dropped(items_.size(), false);
  for (uint32_t p = 0; p < of_pixel.size(); ++p) {
    auto& list = of_pixel[p];
    std::sort(list.begin(), list.end(), [this](uint32_t a, uint32_t b) {
      return items_[a].size() != items_[b].size() ? items_[a].size() < items_[b].size() : a < b;
    });
    double charge = 0;
    for (uint32_t i : list) {
      charge += items_[i].size() / 2;
      if (charge > kDropShare * settings_.tolerance) break;
      dropped[i] = true;
      tally_.decided_without_ray += in_core(p, 0);
      dropped_.push_back(items_[i]);
    }
  }
  size_t kept = 0;
  for (size_t i = 0; i < items_.size(); ++i)
    if (!dropped[i]) items_[kept++] = items_[i];
  items_.resize(kept);
}

/// Adds of the dropped items what the pixel sees of the others, by their first looks.
void BlockLight::add_dropped_items() {
  if (dropped_.empty()) return;
  std::vector<std::array<uint32_t, 2>> rays(block_.pixels());  // lit, dark
  for (const BoundedItem& item : items_) {
    rays[pixel(item)][0] += uint32_t(std::popcount(item.first_lit));
    rays[pixel(item)][1] += uint32_t(std::popcount(item.first_dark));
  }
  for (const BoundedItem& item : dropped_) {
    const auto& [lit, dark] = rays[pixel(item)];
    const double share = expected_share(lit, dark);
    PixelLight& light = out_[pixel(item)];
    light.radiance += item.unshadowed() * share;
    light.error += item.size() * share_deviation(share);
    if (tally_.trace)
      tally_.trace->add(pixel(item), {points_[item.point].bounce, item.luminaire, "too dim for a ray", 0,
                                      item.unshadowed() * share});
    if (parts_)
      add_light(parts_->of(pixel(item)), luminaires_[item.luminaire], points_[item.point],
                {item.diffuse * share, item.diffuse}, {item.phong * share, item.phong});
  }
}

void BlockLight::first_look() {
  for (BoundedItem& item : items_) item_sampler_.look(item, tally_);
}

/// Items whose neighbourhood has seen both light and dark may be in penumbra.
void BlockLight::gate() {
  for (size_t begin = 0; begin < items_.size();) {
    const size_t s = slot(items_[begin]);
    Reused<uint8_t> seen(memory_, block_.pixels());
    size_t end = begin;
    for (; end < items_.size() && slot(items_[end]) == s; ++end)
      seen[pixel(items_[end])] |=
          uint8_t((items_[end].first_lit ? kLit : 0) | (items_[end].first_dark ? kDark : 0));
    spread(seen, block_.width, block_.height, kGateReach);
    for (size_t i = begin; i < end; ++i) {
      if (luminaires_[items_[i].luminaire].is_point()) continue;  // one ray told all
      // Most of the four were below the horizon: a neighbourhood of those has seen next to nothing.
      const bool blind =
          std::popcount(uint8_t(items_[i].first_lit | items_[i].first_dark)) < int(kFirstLook) / 2;
      const bool unproven = luminaires_[items_[i].luminaire].is_wide();  // until the flood's 16 points
      items_[i].uncertain = seen[pixel(items_[i])] == (kLit | kDark) || blind || unproven;
    }
    begin = end;
  }
}

/// Where the first packet of an uncertain item finds penumbra, its neighbours are uncertain too.
void BlockLight::flood() {
  for (size_t begin = 0; begin < items_.size();) {
    const size_t s = slot(items_[begin]);
    Reused<uint8_t> mixed(memory_, block_.pixels());
    size_t end = begin;
    for (; end < items_.size() && slot(items_[end]) == s; ++end) {
      BoundedItem& item = items_[end];
      if (!item.uncertain || !in_core(pixel(item), kFloodReach)) continue;
      item_sampler_.advance(item, next_level(0), tally_);
      mixed[pixel(item)] = item.lit > 0 && item.lit < item.facing;
    }
    spread(mixed, block_.width, block_.height, kFloodReach);
    for (size_t i = begin; i < end; ++i) items_[i].uncertain = items_[i].uncertain || mixed[pixel(items_[i])];
    begin = end;
  }
}

/// What the first looks around a pixel can have missed is the smoothed standard error of all their points; a
/// pixel's share of it is reported, but no more than half the tolerance, which the calibration shows to hold.
void BlockLight::settle_certain_items() {
  const double n = kFirstLook * (2 * kGateReach + 1) * (2 * kGateReach + 1), p = 1 / (n + 2);
  const double missed =
      kItemCalibration.report * kItemCalibration.smoothed * std::sqrt(p * (1 - p)) * std::pow(n, -0.75);
  for (const BoundedItem& item : items_) {
    if (item.uncertain) continue;
    PixelLight& pixel_light = out_[pixel(item)];
    const bool exact = luminaires_[item.luminaire].is_point();
    pixel_light.points += exact ? 1 : kFirstLook;
    if (item.first_lit) pixel_light.radiance += item.unshadowed();
    if (exact) continue;
    double& certain = certain_error_[pixel(item)];
    certain = std::min(std::hypot(certain, missed * item.size()), settings_.tolerance / 2);
  }
}

void BlockLight::refine_tiles() {
  const uint32_t columns = (block_.core_width + kTile - 1) / kTile;
  const uint32_t rows = (block_.core_height + kTile - 1) / kTile;
  std::vector<std::vector<BoundedItem*>> tiles(size_t(columns) * rows);
  for (BoundedItem& item : items_) {
    if (!item.uncertain || !in_core(pixel(item), 0)) continue;
    const uint32_t x = pixel(item) % block_.width - block_.core_x,
                   y = pixel(item) / block_.width - block_.core_y;
    tiles[y / kTile * columns + x / kTile].push_back(&item);
  }
  const TileRefiner refiner(item_sampler_, points_, block_, settings_);
  for (auto& tile : tiles) {
    refiner.refine(tile, out_, tally_);
    for (const BoundedItem* item : tile) out_[pixel(*item)].points += item->count;
  }
  for (uint32_t p = 0; p < block_.pixels(); ++p) {
    out_[p].error = std::hypot(out_[p].error, certain_error_[p]);
    if (in_core(p, 0)) tally_.light_points += out_[p].points;
  }
}

/// An item's light, told apart.
void BlockLight::add_parts(const BoundedItem& item) {
  const double seen = item.first_lit ? 1 : 0;
  const Vec3d diffuse = item.uncertain ? item.diffuse_radiance() : item.diffuse * seen,
              glossy = item.uncertain ? item.glossy_radiance() : item.phong * seen;
  add_light(parts_->of(pixel(item)), luminaires_[item.luminaire], points_[item.point],
            {diffuse, item.diffuse}, {glossy, item.phong});
}

}  // namespace

uint32_t BoundedLight::halo() const {
  return kHalo;
}

void BoundedLight::light(const Block& block, std::span<const Luminaire> luminaires,
                         const std::vector<LitPoint>& points, std::vector<PixelLight>& out, LightTally& tally,
                         LightParts* parts, BlockMemory& memory) const {
  BlockLight(block, geometry_, luminaires, sampler_, settings_, points, out, tally, parts, memory).run();
}

}  // namespace penumbra
