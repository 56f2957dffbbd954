// SPDX-License-Identifier: GPL-3.0-or-later
// Hair and point clouds: keys as they come become what rays are traced against.
#pragma once

#include <cstdint>
#include <vector>

#include "scene/scene.h"

namespace penumbra {

/// `mesh` has the keys of all curves one after the other, counts[i] of curve i. Gives each curve its first
/// and last key twice, so that it reaches them, as Cycles does, and leaves out what no ray could meet: curves
/// of one key, segments without radius or extent. Throws std::invalid_argument, with the mesh's name, where
/// numbers are not finite, radii negative or the counts do not fit.
void make_curves(Mesh& mesh, const std::vector<uint32_t>& counts);

/// The same of spheres: leaves out those without radius.
void make_points(Mesh& mesh);

}  // namespace penumbra
