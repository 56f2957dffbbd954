// SPDX-License-Identifier: GPL-3.0-or-later
// Normals of smooth meshes at their vertices.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "math/vector.h"

namespace penumbra {

/// Polygons as runs of corners, each of which names a vertex.
struct Polygons {
  std::span<const int32_t> starts, totals;
  std::span<const int32_t> corner_vertices;
  std::span<const Vec3f> normals;  // one a polygon, of unit length
};

/// The unit normal of each vertex: its polygons' normals, weighted by the angle at the vertex (Thürmer and
/// Wüthrich, "Computing Vertex Normals from Polygonal Facets", 1998), as Blender has it. Added up in the
/// order of the corners, so that the same mesh has the same normals, bit for bit. A vertex without polygons,
/// or whose polygons cancel, gets the direction of its position. Throws std::out_of_range for polygons or
/// vertices that are not there.
std::vector<Vec3f> vertex_normals(std::span<const Vec3f> positions, const Polygons& polygons);

}  // namespace penumbra
