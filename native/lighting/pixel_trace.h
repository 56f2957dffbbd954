// SPDX-License-Identifier: GPL-3.0-or-later
// What lighting decided in one pixel, for --debug-pixel.
#pragma once

#include <cstdint>
#include <vector>

#include "math/vector.h"

namespace penumbra {

/// About one luminaire at one of the pixel's surface points.
struct LightDecision {
  uint32_t bounce, luminaire;
  const char* decision;
  uint64_t points;  // used
  Vec3d estimate;   // radiance in the pixel
};

struct PixelTrace {
  uint32_t x, y;       // full frame
  uint32_t pixel = 0;  // the same in the block that is being rendered
  std::vector<LightDecision> decisions{};

  void add(uint32_t in_pixel, const LightDecision& decision) {
    if (in_pixel == pixel) decisions.push_back(decision);
  }
};

}  // namespace penumbra
