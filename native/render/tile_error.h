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
  /// edges: the tile's pixels that have edge states.
  TileError(const std::vector<FilteredPixel>& pixels, const FilteredFrame& frame, const Rectangle& tile,
            std::span<const uint32_t> edges, double tolerance);

  /// How edges converge here is learned from the blocks of all pixels, beginning with the calibration's
  /// constant. After each change of the pixels.
  void learn();

  PixelVariance of(uint32_t pixel) const;

 private:
  /// What a pixel's blocks tell.
  struct OfBlocks {
    bool edge = false, sampled = false;
    PixelVariance variance = {};
  };
  OfBlocks& at(uint32_t pixel) {
    return of_blocks_[(pixel / frame_.block_width - y_) * kTile + pixel % frame_.block_width - x_];
  }

  const std::vector<FilteredPixel>& pixels_;
  const FilteredFrame& frame_;
  std::span<const uint32_t> edges_;
  double tolerance_;
  uint32_t x_, y_;                   // of the tile
  std::vector<OfBlocks> of_blocks_;  // by place in it
  PixelVariance smoothed_ = {};      // as shares of what is expected
};

}  // namespace penumbra
