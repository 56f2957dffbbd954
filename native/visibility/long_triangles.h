// SPDX-License-Identifier: GPL-3.0-or-later
// Long, thin triangles across the axes fill next to nothing of their boxes, and rays that miss them pay for
// the boxes. Embree does not split them where it traces robustly.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "math/vector.h"

namespace penumbra {

/// Triangles in place of others.
struct TrianglePieces {
  std::vector<std::array<uint32_t, 3>> corners;
  std::vector<uint32_t> whole;  // number of the triangle that each is a piece of
};

/// Cuts a mesh whose triangles fill little of their boxes at the middles of the edges that cross most of
/// them, and appends those to the positions. An edge is cut alike wherever it is used, so that no gap opens.
/// No pieces: the mesh stays as it is.
TrianglePieces split_long_triangles(std::vector<Vec3f>& positions,
                                    const std::vector<std::array<uint32_t, 3>>& triangles);

}  // namespace penumbra
