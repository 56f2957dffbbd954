// SPDX-License-Identifier: GPL-3.0-or-later
// The standard errors of a tile's filtered pixels, which help each other.
#pragma once

#include "render/sample_packet.h"

namespace penumbra {

/// Of a pixel's estimate, display units squared.
struct PixelVariance {
  double shares;  // of the surfaces in it
  double light;   // on them
};

class TileError {
 public:
  /// edges: the tile's pixels that get samples all over the filter.
  TileError(const std::vector<FilteredPixel>& pixels, const FilteredFrame& frame,
            std::span<const uint32_t> edges, double tolerance);

  /// How edges converge here is learned from the blocks of all pixels, beginning with the calibration's
  /// constant. After each change of the pixels.
  void learn();

  PixelVariance of(uint32_t pixel) const;

 public:
  const std::vector<FilteredPixel>& pixels_;
  const FilteredFrame& frame_;
  std::span<const uint32_t> edges_;
  double tolerance_;
  PixelVariance smoothed_ = {};  // as shares of what is expected
};

}  // namespace penumbra
