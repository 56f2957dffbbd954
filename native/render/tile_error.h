// SPDX-License-Identifier: GPL-3.0-or-later
// The standard errors of a tile's filtered pixels, which help each other.
#pragma once

#include "render/sample_packet.h"

namespace penumbra {

class TileError {
 public:
  /// edges: the tile's pixels that get samples all over the filter. dimensions: of a sample.
  TileError(const std::vector<FilteredPixel>& pixels, const FilteredFrame& frame,
            std::span<const uint32_t> edges, double display_scale, int dimensions);

  /// How edges converge here is learned from the blocks of all pixels, beginning with the calibration's
  /// constant. After each change of the pixels.
  void learn();

  /// Of a pixel's estimate, display units.
  double of(uint32_t pixel) const;

 private:
  double prior(uint32_t pixel) const;

  const std::vector<FilteredPixel>& pixels_;
  const FilteredFrame& frame_;
  std::span<const uint32_t> edges_;
  double display_scale_, exponent_, smoothed_ = 0;
};

}  // namespace penumbra
