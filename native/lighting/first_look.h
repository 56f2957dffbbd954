// SPDX-License-Identifier: GPL-3.0-or-later
// BOUNDED's first look: a few rays from each surface point to each luminaire that is not too dim for any.
#pragma once

#include <vector>

#include "lighting/item_sampler.h"

namespace penumbra {

class FirstLook {
 public:
  /// drop_share: of each pixel's tolerance, what dim luminaires may be charged for being dropped. Items of
  /// the block's points, as they are found.
  FirstLook(const ItemSampler& sampler, const Block& block, std::span<const Luminaire> luminaires,
            const std::vector<LitPoint>& points, const BoundedSettings& settings, double drop_share,
            BlockMemory& memory);

  /// Some more of the points, which are all of some 2 x 2 quads of the frame's pixels; their items, one
  /// luminaire after the other, good until the next call. None: so few that it pays to wait for more, or,
  /// where all points were found, no more.
  std::span<const LookedItem> next(bool all_found, LightTally& tally);

  /// Items that are too dim for a ray.
  const std::vector<LookedItem>& dropped() const { return dropped_; }

 private:
  uint32_t find_quads(uint32_t begin);
  void find_items(uint32_t begin, uint32_t end, LightTally& tally);
  void drop_dim_items(uint32_t begin, LightTally& tally);
  uint64_t slot(const LookedItem& item) const {
    return uint64_t(points_[item.point].bounce) * luminaires_.size() + item.luminaire;
  }

  const ItemSampler& sampler_;
  const Block& block_;
  std::span<const Luminaire> luminaires_;
  const std::vector<LitPoint>& points_;
  const BoundedSettings& settings_;
  double drop_share_;
  uint32_t batch_;
  uint32_t looked_at_ = 0;  // points
  // Of the quads that it is at: each point's quad, and the number of its pixel among theirs; the items.
  std::vector<uint32_t> quad_, place_, group_;
  std::vector<LookedItem> items_;
  std::vector<std::vector<uint32_t>> of_pixel_;
  Reused<LookedItem> dropped_;
};

}  // namespace penumbra
