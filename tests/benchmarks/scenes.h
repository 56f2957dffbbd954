// SPDX-License-Identifier: GPL-3.0-or-later
// Scenes for benchmarks, made by formula: the same on every machine.
#pragma once

#include <string>
#include <vector>

#include "scene/scene.h"

namespace penumbra::benchmark {

/// A name and what makes the scene.
struct NamedScene {
  std::string name;
  Scene (*make)();
};

/// A floor alone, a sphere on a floor (5k triangles), four objects (14k), a field of spheres and leaves (1
/// M), and the same field as 2000 instances.
const std::vector<NamedScene>& scenes();

/// Of this process, all threads.
/// About so many triangles of one mesh; smooth: with normals at their corners.
Mesh bumpy_floor(uint32_t triangles, bool smooth);
/// Under a rectangle, seen from above.
Scene under_a_rectangle(Mesh mesh);

double cpu_seconds();

}  // namespace penumbra::benchmark
