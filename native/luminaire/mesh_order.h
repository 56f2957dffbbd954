// SPDX-License-Identifier: GPL-3.0-or-later
// What an emissive mesh needs to know of its triangles as a whole.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "math/transform.h"

namespace penumbra {

using Corners = std::array<uint32_t, 3>;

/// Every edge belongs to two triangles that run along it in opposite directions: the mesh has an inside.
bool is_closed(const std::vector<Corners>& triangles);

/// The triangles of a closed mesh, each connected part turned so that its volume is positive.
std::vector<Corners> outward(std::vector<Corners> triangles, const std::vector<Vec3d>& positions);

/// The triangles' numbers along a Morton curve through their centres.
std::vector<size_t> curve_order(const std::vector<Corners>& triangles, const std::vector<Vec3d>& positions,
                                const Box& bounds);

}  // namespace penumbra
