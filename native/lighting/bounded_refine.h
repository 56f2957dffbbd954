// SPDX-License-Identifier: GPL-3.0-or-later
// BOUNDED's second half: rays for uncertain items until each pixel of a tile is within the tolerance.
#pragma once

#include <vector>

#include "lighting/item_sampler.h"

namespace penumbra {

/// Calibrated constants; how they were found: tests/benchmarks/README.md.
struct BoundedCalibration {
  /// Quantile that stopping tests, in units of the estimated standard error: about 99 % of the pixels.
  double stop = 2.85;
  /// Quantile of the Error Estimate pass: 95 %.
  double report = 2.2;
  /// What an item's error is before its neighbours are asked, the smoothed standard error
  /// c G sqrt(p (1 - p)) n^-3/4 (G: the unshadowed value, p: the visible fraction), and how many neighbours
  /// that counts as.
  double smoothed = 1.2, prior_weight = 6.0;
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
  double error(const BoundedItem& item, const std::vector<BoundedItem*>& items) const;

  const ItemSampler& sampler_;
  const std::vector<LitPoint>& points_;
  const Block& block_;
  const BoundedSettings& settings_;
  BoundedCalibration calibration_;
};

}  // namespace penumbra
