// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/tile_error.h"

#include <cstdlib>

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
                     std::span<const uint32_t> edges, double tolerance)
    : pixels_(pixels), frame_(frame), edges_(edges), tolerance_(tolerance) {}

void TileError::learn() {
  constexpr double kExpected = kPixelCalibration.smoothed * kPixelCalibration.smoothed;
  PooledVariance shares(kExpected, kTileWeight), light(kExpected, kTileWeight);
  // Of pixels with next to no light a share of what they expect means nothing.
  const double negligible = kNegligible * kNegligible * tolerance_ * tolerance_;
  const auto add = [negligible](PooledVariance& pooled, const PartVariance& part) {
    if (part.expected > negligible) pooled.add(part.by_blocks / part.expected);
  };
  for (uint32_t p : edges_) {
    add(shares, pixels_[p].edge->shares);
    add(light, pixels_[p].edge->light);
  }
  smoothed_ = {shares.mean(), light.mean()};
}

PixelVariance TileError::of(uint32_t p) const {
  const int width = int(frame_.block_width), x = int(p) % width, y = int(p) / width;
  const EdgeState& edge = *pixels_[p].edge;
  PooledVariance shares(smoothed_.shares * edge.shares.expected, kPixelCalibration.prior_weight),
      light(smoothed_.light * edge.light.expected, kPixelCalibration.prior_weight);
  for (uint32_t q : edges_) {
    if (std::abs(int(q) % width - x) > kPool || std::abs(int(q) / width - y) > kPool) continue;
    shares.add(pixels_[q].edge->shares.by_blocks);
    light.add(pixels_[q].edge->light.by_blocks);
  }
  return {shares.mean() * edge.shares.fall, light.mean() * edge.light.fall + edge.unknown};
}

}  // namespace penumbra
