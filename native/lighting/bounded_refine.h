// SPDX-License-Identifier: GPL-3.0-or-later
// BOUNDED's second half: rays for uncertain items until each pixel of a tile is within the tolerance.
#pragma once

#include <vector>

#include "lighting/item_sampler.h"
#include "visibility/chords.h"

namespace penumbra {

/// A tile's items by slot (bounce and luminaire) and place, so that neighbours are found without a search.
class TileItems {
 public:
  /// What neighbours ask of an item.
  struct Known {
    uint32_t count = 0;   // none: no item
    bool lines = false;   // are what is counted
    double variance = 0;  // for as many; of lines for half of them
    double quarter_variance = 0;
  };

  TileItems(const std::vector<BoundedItem*>& items, const std::vector<LitPoint>& points, const Block& block);

  /// Calls function(known) of those of an item's slot at most `reach` pixels away in x and y, row by row,
  /// that have lines if it has, points if not.
  template <typename Function>
  void for_neighbours(const BoundedItem& item, int reach, Function function) const;
  /// Of the tile's items, in an order that does not depend on the block.
  size_t index(const BoundedItem& item) const;
  /// Called when an item has got more points.
  void update(const BoundedItem& item) {
    Known& known = known_[index(item)];
    known = item.lines > 0 ? Known{item.lines, true, item.half_variance, item.quarter_variance}
                           : Known{item.count, false, item.variance, 0};
  }

 private:
  struct Place {
    int x, y;  // in the tile
  };
  Place place(const BoundedItem& item) const;
  uint64_t slot(const BoundedItem& item) const {
    return uint64_t(points_[item.point].bounce) << 32 | item.luminaire;
  }

  const std::vector<LitPoint>& points_;
  const Block& block_;
  std::vector<uint64_t> slots_;  // sorted
  std::vector<Known> known_;     // by slot, row and column
};

/// Of a tile: memory for lines, and how many occluders some item of it was found to have, and more.
struct LineSearch {
  Chords chords;
  uint32_t refused = 0;
};

/// The uncertain items of one tile, with their places, and what else its pixels have.
class TileRefiner {
 public:
  TileRefiner(const ItemSampler& sampler, const std::vector<LitPoint>& points, const Block& block,
              const BoundedSettings& settings);

  /// items: uncertain ones of this tile, all slots. certain: display value and error charged already, by
  /// pixel of the block. Leaves each pixel's items within the tolerance, or at the limit.
  void refine(std::vector<BoundedItem*>& items, std::vector<PixelLight>& pixels, LightTally& tally) const;

 private:
  /// Of an item, display units.
  struct Error {
    double standard, report;  // what stopping tests, and a bound of 95 %
  };
  Error error(const BoundedItem& item, const TileItems& items) const;
  Error line_error(const BoundedItem& item, const TileItems& items) const;
  bool can_advance(const BoundedItem& item) const;
  void advance(BoundedItem& item, double points_wanted, LineSearch& search, LightTally& tally) const;

  const ItemSampler& sampler_;
  const std::vector<LitPoint>& points_;
  const Block& block_;
  const BoundedSettings& settings_;
};

}  // namespace penumbra
