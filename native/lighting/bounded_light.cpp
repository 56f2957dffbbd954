// SPDX-License-Identifier: GPL-3.0-or-later
#include "lighting/bounded_light.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <deque>

#include "lighting/bounded_refine.h"
#include "lighting/first_look.h"
#include "lighting/light_parts.h"
#include "lighting/pooled_error.h"
#include "lighting/spread.h"

namespace penumbra {
namespace {

/// The gate looks at pixels this far to each side; the flood carries what refining found as far again.
constexpr int kGateReach = 3, kFloodReach = 2;
/// Even: whole quads, whose first looks share packets.
constexpr uint32_t kHalo = (kGateReach + kFloodReach + 1) / 2 * 2;

/// Share of a pixel's tolerance that dim luminaires may be charged for being dropped.
constexpr double kDropShare = 0.25;

enum Seen : uint8_t { kLit = 1, kDark = 2 };

/// An item, and the number of its BoundedItem where it is uncertain.
struct BlockItem : LookedItem {
  static constexpr uint32_t kNone = ~0u;
  uint32_t refined = kNone;

  bool uncertain() const { return refined != kNone; }
};

/// Of independent errors.
double sum_of_errors(double a, double b) {
  return a == 0 ? b : b == 0 ? a : std::hypot(a, b);
}

/// Items of one bounce and one luminaire, which are compared with each other.
struct Slot {
  Slot(BlockMemory& memory, uint32_t pixels) : items(memory), seen(memory, pixels) {}

  Reused<BlockItem> items;
  Reused<uint8_t> seen;  // by pixel
  uint8_t seen_by_any = 0;
};

/// The light of one block, step by step.
class BlockLight final : public BlockLighting {
 public:
  BlockLight(const LitBlock& block, const Geometry& geometry, const Sampler& sampler,
             const BoundedSettings& settings)
      : block_(block.block),
        luminaires_(block.luminaires),
        settings_(settings),
        points_(block.points),
        out_(block.out),
        tally_(block.tally),
        parts_(block.parts),
        memory_(block.memory),
        item_sampler_(geometry, luminaires_, sampler, points_, settings),
        first_look_(item_sampler_, block_, luminaires_, points_, settings_, kDropShare, memory_),
        refined_(memory_),
        certain_error_(memory_, block_.pixels(), 0.0) {}

  void look() override { look(false); }

  void finish() override {
    look(true);
    add_dropped_items();
    for (Slot& slot : slots_) gate(slot);
    for (Slot& slot : slots_) flood(slot);
    for_items([this](const BlockItem& item) { settle(item); });
    refine_tiles();
    if (parts_) for_items([this](const BlockItem& item) { add_parts(item); });
    if (tally_.trace)
      for_items([this](const BlockItem& item) { tally_.trace->add(item.pixel, decision(item)); });
  }

 private:
  size_t slot(const LookedItem& item) const {
    return points_[item.point].bounce * luminaires_.size() + item.luminaire;
  }
  template <typename Function>
  void for_items(Function function) {
    for (Slot& slot : slots_)
      for (BlockItem& item : slot.items) function(item);
  }

  LightDecision decision(const BlockItem& item) const;
  void look(bool all_found);
  void add_dropped_items();
  void make_uncertain(BlockItem& item);
  void gate(Slot& slot);
  void flood(Slot& slot);
  void settle(const BlockItem& item);
  void refine_tiles();
  void add_parts(const BlockItem& item);

  const Block& block_;
  std::span<const Luminaire> luminaires_;
  const BoundedSettings& settings_;
  const std::vector<LitPoint>& points_;
  std::vector<PixelLight>& out_;
  LightTally& tally_;
  LightParts* parts_;
  BlockMemory& memory_;
  ItemSampler item_sampler_;
  FirstLook first_look_;
  std::deque<Slot> slots_;
  Reused<BoundedItem> refined_;
  Reused<double> certain_error_;  // of each pixel's certain items, display units
};

LightDecision BlockLight::decision(const BlockItem& item) const {
  const uint32_t bounce = points_[item.point].bounce;
  if (item.uncertain()) {
    const BoundedItem& refined = refined_[item.refined];
    return {bounce, item.luminaire, "may be in penumbra", refined.count, refined.radiance()};
  }
  return item.first_lit ? LightDecision{bounce, item.luminaire, "wholly seen", kFirstLook, item.unshadowed()}
                        : LightDecision{bounce, item.luminaire, "wholly hidden", kFirstLook, {}};
}

void BlockLight::look(bool all_found) {
  for (std::span<const LookedItem> items; !(items = first_look_.next(all_found, tally_)).empty();) {
    for (const LookedItem& item : items) {
      while (slots_.size() <= slot(item)) slots_.emplace_back(memory_, block_.pixels());
      Slot& own = slots_[slot(item)];
      own.items.push_back({item});
      const uint8_t seen = uint8_t((item.first_lit ? kLit : 0) | (item.first_dark ? kDark : 0));
      own.seen[item.pixel] |= seen;
      own.seen_by_any |= seen;
    }
  }
}

/// Adds of the dropped items what the pixel sees of the others, by their first looks.
void BlockLight::add_dropped_items() {
  if (first_look_.dropped().empty()) return;
  Reused<std::array<uint32_t, 2>> rays(memory_, block_.pixels());  // lit, dark
  for_items([&](const BlockItem& item) {
    rays[item.pixel][0] += uint32_t(std::popcount(item.first_lit));
    rays[item.pixel][1] += uint32_t(std::popcount(item.first_dark));
  });
  for (const LookedItem& item : first_look_.dropped()) {
    const auto& [lit, dark] = rays[item.pixel];
    const double share = expected_share(lit, dark);
    PixelLight& light = out_[item.pixel];
    light.radiance += item.unshadowed() * share;
    light.error += item.size() * share_deviation(share);
    if (tally_.trace)
      tally_.trace->add(item.pixel, {points_[item.point].bounce, item.luminaire, "too dim for a ray", 0,
                                     item.unshadowed() * share});
    if (parts_)
      add_light(parts_->of(item.pixel), luminaires_[item.luminaire], points_[item.point],
                {item.diffuse * share, item.diffuse}, {item.phong * share, item.phong});
  }
}

void BlockLight::make_uncertain(BlockItem& item) {
  if (item.uncertain()) return;
  item.refined = uint32_t(refined_.size());
  refined_.push_back(item);
}

/// Items of a slot whose neighbourhood has seen both light and dark may be in penumbra.
void BlockLight::gate(Slot& slot) {
  if (slot.items.empty()) return;
  const Luminaire& luminaire = luminaires_[slot.items.front().luminaire];
  if (luminaire.is_point()) return;  // one ray told all
  if (slot.seen_by_any == (kLit | kDark)) spread(slot.seen, block_.width, block_.height, kGateReach);
  for (BlockItem& item : slot.items) {
    // Most of the four were below the horizon: a neighbourhood of those has seen next to nothing.
    const bool blind = std::popcount(uint8_t(item.first_lit | item.first_dark)) < int(kFirstLook) / 2;
    const bool unproven = luminaire.is_wide();  // until the flood's 16 points
    if (slot.seen[item.pixel] == (kLit | kDark) || blind || unproven) make_uncertain(item);
  }
}

/// Where the first packet of an uncertain item finds penumbra, its neighbours are uncertain too.
void BlockLight::flood(Slot& slot) {
  Reused<uint8_t> mixed(memory_, block_.pixels());
  bool any = false;
  for (const BlockItem& item : slot.items) {
    if (!item.uncertain() || !block_.in_core(item.pixel, kFloodReach)) continue;
    BoundedItem& refined = refined_[item.refined];
    item_sampler_.advance(refined, next_level(0), tally_);
    mixed[item.pixel] = refined.lit > 0 && refined.lit < refined.facing;
    any = any || mixed[item.pixel];
  }
  if (!any) return;
  spread(mixed, block_.width, block_.height, kFloodReach);
  for (BlockItem& item : slot.items)
    if (mixed[item.pixel]) make_uncertain(item);
}

/// A certain item's light. What the first looks around a pixel can have missed is the smoothed standard error
/// of all their points; a pixel's share of it is reported, but no more than half the tolerance, which the
/// calibration shows to hold.
void BlockLight::settle(const BlockItem& item) {
  static const double n = kFirstLook * (2 * kGateReach + 1) * (2 * kGateReach + 1), p = 1 / (n + 2);
  static const double missed =
      kItemCalibration.report * kItemCalibration.smoothed * std::sqrt(p * (1 - p)) * std::pow(n, -0.75);
  if (item.uncertain()) return;
  PixelLight& pixel_light = out_[item.pixel];
  const bool exact = luminaires_[item.luminaire].is_point();
  pixel_light.points += exact ? 1 : kFirstLook;
  if (item.first_lit) pixel_light.radiance += item.unshadowed();
  if (exact) return;
  double& certain = certain_error_[item.pixel];
  certain = std::min(sum_of_errors(certain, missed * item.size()), settings_.tolerance / 2);
}

void BlockLight::refine_tiles() {
  const uint32_t columns = (block_.core_width + kTile - 1) / kTile;
  const uint32_t rows = (block_.core_height + kTile - 1) / kTile;
  std::vector<std::vector<BoundedItem*>> tiles(size_t(columns) * rows);
  for_items([&](const BlockItem& item) {
    if (!item.uncertain() || !block_.in_core(item.pixel, 0)) return;
    const uint32_t x = item.pixel % block_.width - block_.core_x,
                   y = item.pixel / block_.width - block_.core_y;
    tiles[y / kTile * columns + x / kTile].push_back(&refined_[item.refined]);
  });
  const TileRefiner refiner(item_sampler_, points_, block_, settings_);
  for (auto& tile : tiles) {
    refiner.refine(tile, out_, tally_);
    for (const BoundedItem* item : tile) out_[item->pixel].points += item->count;
  }
  for (uint32_t y = 0; y < block_.core_height; ++y) {
    const uint32_t row = (block_.core_y + y) * block_.width + block_.core_x;
    for (uint32_t p = row; p < row + block_.core_width; ++p) {
      out_[p].error = sum_of_errors(out_[p].error, certain_error_[p]);
      tally_.light_points += out_[p].points;
    }
  }
}

/// An item's light, told apart.
void BlockLight::add_parts(const BlockItem& item) {
  Vec3d diffuse, glossy;
  if (item.uncertain())
    diffuse = refined_[item.refined].diffuse_radiance(), glossy = refined_[item.refined].glossy_radiance();
  else if (item.first_lit)
    diffuse = item.diffuse, glossy = item.phong;
  add_light(parts_->of(item.pixel), luminaires_[item.luminaire], points_[item.point], {diffuse, item.diffuse},
            {glossy, item.phong});
}

}  // namespace

uint32_t BoundedLight::halo() const {
  return kHalo;
}

std::unique_ptr<BlockLighting> BoundedLight::begin(const LitBlock& block) const {
  return std::make_unique<BlockLight>(block, geometry_, sampler_, settings_);
}

}  // namespace penumbra
