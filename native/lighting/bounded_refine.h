// SPDX-License-Identifier: GPL-3.0-or-later
// BOUNDED's second half: rays for uncertain items until each pixel of a tile is within the tolerance.
#pragma once

#include <vector>

#include "lighting/item_sampler.h"

namespace penumbra {

/// A tile's items by slot (bounce and luminaire) and place, so that neighbours are found without a search.
class TileItems {
 public:
  TileItems(const std::vector<BoundedItem*>& items, const std::vector<LitPoint>& points, const Block& block);

  /// Calls function(points, variance) of those of an item's slot at most `reach` pixels away in x and y, row
  /// by row.
  template <typename Function>
  void for_neighbours(const BoundedItem& item, int reach, Function function) const;
  /// Called when an item has got more points.
  void update(const BoundedItem& item) {
    Known& known = known_[index(item)];
    known = {item.count, item.variance};
  }

 private:
  struct Place {
    int x, y;  // in the tile
  };
  /// What neighbours ask of an item.
  struct Known {
    uint32_t count = 0;  // none: no item
    double variance = 0;
  };
  Place place(const BoundedItem& item) const;
  size_t index(const BoundedItem& item) const;
  uint64_t slot(const BoundedItem& item) const {
    return uint64_t(points_[item.point].bounce) << 32 | item.luminaire;
  }

  const std::vector<LitPoint>& points_;
  const Block& block_;
  std::vector<uint64_t> slots_;  // sorted
  std::vector<Known> known_;     // by slot, row and column
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
  double error(const BoundedItem& item, const TileItems& items) const;

  const ItemSampler& sampler_;
  const std::vector<LitPoint>& points_;
  const Block& block_;
  const BoundedSettings& settings_;
};

}  // namespace penumbra
