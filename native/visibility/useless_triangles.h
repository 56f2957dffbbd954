// SPDX-License-Identifier: GPL-3.0-or-later
// Triangles that rays gain nothing from: those without area, and copies of others.
#pragma once

#include <cstdint>

#include "scene/scene.h"

namespace penumbra {

struct UselessTriangles {
  size_t without_area = 0, copies = 0;

  size_t count() const { return without_area + copies; }
};

/// Takes them out of a mesh, corner normals and material slots included, and counts them. A copy has the same
/// three positions, in any order, as a triangle before it; of several the first one stays. Hundreds of
/// thousands of copies at one place would cost each ray milliseconds, and which one of them it meets is
/// undefined.
UselessTriangles remove_useless_triangles(Mesh& mesh);

}  // namespace penumbra
