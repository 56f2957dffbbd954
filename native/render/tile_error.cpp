// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/tile_error.h"

#include <cmath>
#include <cstdlib>

#include "lighting/pooled_error.h"

namespace penumbra {
namespace {

/// Pixels to each side whose variances are pooled, and how many pixels the calibration's constant counts as
/// where the tile's own is learned.
constexpr int kPool = 2;
constexpr double kTileWeight = 4;

}  // namespace

TileError::TileError(const std::vector<FilteredPixel>& pixels, const FilteredFrame& frame,
                     std::span<const uint32_t> edges, double display_scale, int dimensions)
    : pixels_(pixels),
      frame_(frame),
      edges_(edges),
      display_scale_(display_scale),
      exponent_(0.5 + 0.6 / dimensions) {}

/// Of the estimate, before its own and its neighbours' blocks are asked; for c = 1.
double TileError::prior(uint32_t p) const {
  return pixels_[p].prior_variance(frame_.of_pixel(p), display_scale_, exponent_);
}

void TileError::learn() {
  PooledVariance c(kPixelCalibration.smoothed * kPixelCalibration.smoothed, kTileWeight);
  for (uint32_t p : edges_)
    if (const double expected = prior(p); expected > 0) c.add(pixels_[p].variance / expected, 1, 0);
  smoothed_ = c.mean();
}

double TileError::of(uint32_t p) const {
  const int width = int(frame_.block_width), x = int(p) % width, y = int(p) / width;
  PooledVariance pooled(smoothed_ * prior(p), kPixelCalibration.prior_weight);
  for (uint32_t q : edges_) {
    if (std::abs(int(q) % width - x) > kPool || std::abs(int(q) / width - y) > kPool) continue;
    pooled.add(pixels_[q].variance, double(pixels_[q].count) / pixels_[p].count, 2 * exponent_);
  }
  return std::sqrt(pooled.mean() + pixels_[p].unknown_variance(frame_.of_pixel(p), display_scale_));
}

}  // namespace penumbra
