// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/tile_error.h"

#include <algorithm>

#include "lighting/pooled_error.h"

namespace penumbra {
namespace {

/// Pixels to each side whose variances are pooled, and how many pixels the calibration's constant counts as
/// where the tile's own is learned.
constexpr int kPool = 2;
constexpr double kTileWeight = 4;

/// Share of the tolerance below which a sample's deviation does not matter. Guarded by
/// test_pixels_without_light_do_not_make_the_others_dear.
constexpr double kNegligible = 0.1;

}  // namespace

TileError::TileError(const std::vector<FilteredPixel>& pixels, const FilteredFrame& frame,
                     const Rectangle& tile, std::span<const uint32_t> edges, double tolerance)
    : pixels_(pixels),
      frame_(frame),
      edges_(edges),
      tolerance_(tolerance),
      x_(tile.x),
      y_(tile.y),
      of_blocks_(kTile * kTile) {}

void TileError::learn() {
  constexpr double kExpected = kPixelCalibration.smoothed * kPixelCalibration.smoothed;
  PooledVariance shares(kExpected, kTileWeight), light(kExpected, kTileWeight);
  // Of pixels with next to no light a share of what they expect means nothing.
  const double negligible = kNegligible * kNegligible * tolerance_ * tolerance_;
  const auto add = [negligible](PooledVariance& pooled, const PartVariance& part) {
    if (part.expected > negligible) pooled.add(part.by_blocks / part.expected);
  };
  for (uint32_t p : edges_) {
    const EdgeState& edge = *pixels_[p].edge;
    add(shares, edge.shares);
    add(light, edge.light);
    at(p) = {true, pixels_[p].count > 0, {edge.shares.by_blocks, edge.light.by_blocks}};
  }
  smoothed_ = {shares.mean(), light.mean()};
}

PixelVariance TileError::of(uint32_t p) const {
  const EdgeState& edge = *pixels_[p].edge;
  PooledVariance shares(smoothed_.shares * edge.shares.expected, kPixelCalibration.prior_weight),
      light(smoothed_.light * edge.light.expected, kPixelCalibration.prior_weight);
  const int x = int(p % frame_.block_width - x_), y = int(p / frame_.block_width - y_);
  for (int row = std::max(y - kPool, 0); row <= std::min(y + kPool, int(kTile) - 1); ++row) {
    for (int column = std::max(x - kPool, 0); column <= std::min(x + kPool, int(kTile) - 1); ++column) {
      const OfBlocks& other = of_blocks_[size_t(row) * kTile + size_t(column)];
      if (!other.edge) continue;
      shares.add(other.variance.shares);
      if (other.sampled) light.add(other.variance.light);
    }
  }
  const bool sampled = pixels_[p].count > 0;
  return {shares.mean() * edge.shares.fall, (sampled ? light.mean() * edge.light.fall : 0) + edge.unknown};
}

}  // namespace penumbra
