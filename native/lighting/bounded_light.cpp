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

/// Quads of pixels to which a luminaire sends less than so many tolerances look at one point of it, to which
/// it sends less than twice that at two. A pixel that is wholly wrong about it is off by no more; what 49
/// points around a pixel can have missed is a twentieth of it (test_many_luminaires.py).
constexpr double kDimSize = 2;
/// Of so few luminaires all get all their points: fewer rays would save no time that could be measured.
constexpr size_t kFewLooks = 4;

enum Seen : uint8_t { kLit = 1, kDark = 2 };

/// An item without its light.
struct BlockItem {
  static constexpr uint32_t kNone = ~0u;

  uint32_t point, pixel;
  uint32_t refined;  // the number of its BoundedItem where it is uncertain
  uint8_t first_lit, first_dark, looks;

  bool uncertain() const { return refined != kNone; }
};

/// Of independent errors.
double sum_of_errors(double a, double b) {
  return a == 0 ? b : b == 0 ? a : std::hypot(a, b);
}

/// Items of one bounce and one luminaire, which are compared with each other. Most are certain, and there are
/// many: what each takes goes through memory a few times.
struct Slot {
  Slot(BlockMemory& memory, uint32_t pixels, uint32_t its_luminaire)
      : luminaire(its_luminaire), items(memory), diffuse(memory), phong(memory), seen(memory, pixels) {}

  void add(const LookedItem& item) {
    if (!(item.phong == Vec3d{})) phong.resize(items.size());
    items.push_back({item.point, item.pixel, BlockItem::kNone, item.first_lit, item.first_dark, item.looks});
    diffuse.push_back(item.diffuse);
    if (!phong.empty() || !(item.phong == Vec3d{})) phong.push_back(item.phong);
  }
  Vec3d phong_of(size_t i) const { return phong.empty() ? Vec3d{} : phong[i]; }
  Vec3d unshadowed(size_t i) const { return diffuse[i] + phong_of(i); }

  uint32_t luminaire;
  Reused<BlockItem> items;
  Reused<Vec3d> diffuse, phong;  // of each item, unshadowed; no phong: none has any
  Reused<uint8_t> seen;          // by pixel
  uint8_t seen_by_any = 0;
};

/// How far a pixel of the block is from those that get their final values.
enum Zone : uint8_t { kCore, kNearCore, kOutside };

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
        first_look_(item_sampler_, block_, luminaires_, points_, settings_, kDropShare, memory_,
                    luminaires_.size() > kFewLooks ? kDimSize * settings_.tolerance : 0),
        zones_(memory_, block_.pixels(), kOutside),
        rays_(memory_),
        refined_(memory_),
        certain_error_(memory_, block_.pixels(), 0.0) {
    for (uint32_t p = 0; p < block_.pixels(); ++p)
      if (block_.in_core(p, kFloodReach)) zones_[p] = block_.in_core(p, 0) ? kCore : kNearCore;
    if (luminaires_.size() > 1) rays_.assign(block_.pixels(), {});
  }

  void look() override { look(false); }

  void finish() override {
    look(true);
    add_dropped_items();
    for (Slot& slot : slots_) {
      gate(slot);
      flood(slot);
      settle(slot);
    }
    refine_tiles();
    if (parts_) for_core_items([this](const Slot& slot, size_t i) { add_parts(slot, i); });
    if (tally_.trace)
      for_core_items(
          [this](const Slot& slot, size_t i) { tally_.trace->add(slot.items[i].pixel, decision(slot, i)); });
  }

 private:
  size_t slot(const LookedItem& item) const {
    return points_[item.point].bounce * luminaires_.size() + item.luminaire;
  }
  template <typename Function>
  void for_core_items(Function function) {
    for (const Slot& slot : slots_)
      for (size_t i = 0; i < slot.items.size(); ++i)
        if (zones_[slot.items[i].pixel] == kCore) function(slot, i);
  }

  LightDecision decision(const Slot& slot, size_t i) const;
  void look(bool all_found);
  void add_dropped_items();
  void make_uncertain(Slot& slot, size_t i);
  void gate(Slot& slot);
  void flood(Slot& slot);
  void settle(const Slot& slot);
  void refine_tiles();
  void add_parts(const Slot& slot, size_t i);

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
  Reused<Zone> zones_;                    // by pixel
  Reused<std::array<uint32_t, 2>> rays_;  // by pixel: of all first looks, lit and dark
  Reused<BoundedItem> refined_;
  Reused<double> certain_error_;  // of each pixel's certain items, display units
};

LightDecision BlockLight::decision(const Slot& slot, size_t i) const {
  const BlockItem& item = slot.items[i];
  const uint32_t bounce = points_[item.point].bounce;
  if (item.uncertain()) {
    const BoundedItem& refined = refined_[item.refined];
    return {bounce, slot.luminaire, "may be in penumbra", refined.used(), refined.radiance()};
  }
  return item.first_lit ? LightDecision{bounce, slot.luminaire, "wholly seen", item.looks, slot.unshadowed(i)}
                        : LightDecision{bounce, slot.luminaire, "wholly hidden", item.looks, {}};
}

void BlockLight::look(bool all_found) {
  for (std::span<const LookedItem> items; !(items = first_look_.next(all_found, tally_)).empty();) {
    for (const LookedItem& item : items) {
      while (slots_.size() <= slot(item))
        slots_.emplace_back(memory_, block_.pixels(), uint32_t(slots_.size() % luminaires_.size()));
      Slot& own = slots_[slot(item)];
      own.add(item);
      const uint8_t seen = uint8_t((item.first_lit ? kLit : 0) | (item.first_dark ? kDark : 0));
      own.seen[item.pixel] |= seen;
      own.seen_by_any |= seen;
      if (rays_.empty()) continue;
      rays_[item.pixel][0] += uint32_t(std::popcount(item.first_lit));
      rays_[item.pixel][1] += uint32_t(std::popcount(item.first_dark));
    }
  }
}

/// Adds of the dropped items what the pixel sees of the others, by their first looks.
void BlockLight::add_dropped_items() {
  for (const LookedItem& item : first_look_.dropped()) {
    if (zones_[item.pixel] != kCore) continue;
    const auto& [lit, dark] = rays_[item.pixel];
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

void BlockLight::make_uncertain(Slot& slot, size_t i) {
  BlockItem& item = slot.items[i];
  if (item.uncertain()) return;
  item.refined = uint32_t(refined_.size());
  LookedItem looked;
  looked.point = item.point, looked.pixel = item.pixel, looked.luminaire = slot.luminaire;
  looked.set_light(slot.diffuse[i], slot.phong_of(i), settings_.display_scale);
  looked.first_lit = item.first_lit, looked.first_dark = item.first_dark, looked.looks = item.looks,
  looked.looked = true;
  refined_.push_back(looked);
}

/// Items of a slot whose neighbourhood has seen both light and dark may be in penumbra.
void BlockLight::gate(Slot& slot) {
  const Luminaire& luminaire = luminaires_[slot.luminaire];
  if (luminaire.is_point()) return;  // one ray told all
  if (slot.seen_by_any == (kLit | kDark)) spread(slot.seen, block_.width, block_.height, kGateReach);
  for (size_t i = 0; i < slot.items.size(); ++i) {
    const BlockItem& item = slot.items[i];
    if (zones_[item.pixel] == kOutside) continue;
    // Most of its points were below the horizon: a neighbourhood of those has seen next to nothing.
    const bool blind = 2 * std::popcount(uint8_t(item.first_lit | item.first_dark)) < int(item.looks);
    const bool unproven = luminaire.is_wide();  // until the flood's 16 points
    if (slot.seen[item.pixel] == (kLit | kDark) || blind || unproven) make_uncertain(slot, i);
  }
}

/// Where the first packet of an uncertain item finds penumbra, its neighbours are uncertain too.
void BlockLight::flood(Slot& slot) {
  Reused<uint8_t> mixed(memory_);
  for (const BlockItem& item : slot.items) {
    if (!item.uncertain()) continue;
    BoundedItem& refined = refined_[item.refined];
    item_sampler_.advance(refined, next_level(0), tally_);
    if (refined.lit == 0 || refined.lit == refined.facing) continue;
    if (mixed.empty()) mixed.assign(block_.pixels(), 0);
    mixed[item.pixel] = true;
  }
  if (mixed.empty()) return;
  spread(mixed, block_.width, block_.height, kFloodReach);
  for (size_t i = 0; i < slot.items.size(); ++i)
    if (mixed[slot.items[i].pixel] && zones_[slot.items[i].pixel] == kCore) make_uncertain(slot, i);
}

/// A certain item's light. What the first looks around a pixel can have missed is the smoothed standard error
/// of all their points; a pixel's share of it is reported, but no more than half the tolerance, which the
/// calibration shows to hold.
void BlockLight::settle(const Slot& slot) {
  static const std::array<double, kFirstLook + 1> missed_by = [] {
    std::array<double, kFirstLook + 1> missed{};
    for (uint32_t looks = 1; looks <= kFirstLook; ++looks) {
      const double n = looks * (2 * kGateReach + 1) * (2 * kGateReach + 1), p = 1 / (n + 2);
      missed[looks] =
          kItemCalibration.report * kItemCalibration.smoothed * std::sqrt(p * (1 - p)) * std::pow(n, -0.75);
    }
    return missed;
  }();
  const bool exact = luminaires_[slot.luminaire].is_point();
  for (size_t i = 0; i < slot.items.size(); ++i) {
    const BlockItem& item = slot.items[i];
    if (item.uncertain() || zones_[item.pixel] != kCore) continue;
    PixelLight& pixel_light = out_[item.pixel];
    pixel_light.points += exact ? 1 : item.looks;
    if (item.first_lit) pixel_light.radiance += slot.unshadowed(i);
    if (exact) continue;
    const double size = light_size(slot.diffuse[i], settings_.display_scale) +
                        light_size(slot.phong_of(i), settings_.display_scale);
    double& certain = certain_error_[item.pixel];
    certain = std::min(sum_of_errors(certain, missed_by[item.looks] * size), settings_.tolerance / 2);
  }
}

void BlockLight::refine_tiles() {
  const uint32_t columns = (block_.core_width + kTile - 1) / kTile;
  const uint32_t rows = (block_.core_height + kTile - 1) / kTile;
  std::vector<std::vector<BoundedItem*>> tiles(size_t(columns) * rows);
  for (BoundedItem& item : refined_) {
    if (zones_[item.pixel] != kCore) continue;
    const uint32_t x = item.pixel % block_.width - block_.core_x,
                   y = item.pixel / block_.width - block_.core_y;
    tiles[y / kTile * columns + x / kTile].push_back(&item);
  }
  const TileRefiner refiner(item_sampler_, points_, block_, settings_);
  for (auto& tile : tiles) {
    refiner.refine(tile, out_, tally_);
    for (const BoundedItem* item : tile) out_[item->pixel].points += item->used();
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
void BlockLight::add_parts(const Slot& slot, size_t i) {
  const BlockItem& item = slot.items[i];
  const Vec3d unshadowed = slot.diffuse[i], unshadowed_phong = slot.phong_of(i);
  Vec3d diffuse, glossy;
  if (item.uncertain())
    diffuse = refined_[item.refined].diffuse_radiance(), glossy = refined_[item.refined].glossy_radiance();
  else if (item.first_lit)
    diffuse = unshadowed, glossy = unshadowed_phong;
  add_light(parts_->of(item.pixel), luminaires_[slot.luminaire], points_[item.point], {diffuse, unshadowed},
            {glossy, unshadowed_phong});
}

}  // namespace

uint32_t BoundedLight::halo() const {
  return kHalo;
}

std::unique_ptr<BlockLighting> BoundedLight::begin(const LitBlock& block) const {
  return std::make_unique<BlockLight>(block, geometry_, sampler_, settings_);
}

}  // namespace penumbra
