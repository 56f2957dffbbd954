// SPDX-License-Identifier: GPL-3.0-or-later
// Normals at vertices against symmetry: however a cube's faces are cut, those at its corners go along the
// diagonals.
#include <gtest/gtest.h>

#include <stdexcept>

#include "scene/vertex_normals.h"

namespace penumbra {
namespace {

/// A cube around a point far from the origin, five faces as quads, the top as two triangles.
struct Cube {
  std::vector<Vec3f> positions;
  std::vector<int32_t> starts{0, 4, 8, 12, 16, 20, 23}, totals{4, 4, 4, 4, 4, 3, 3};
  std::vector<int32_t> corners{0, 2, 3, 1, 0, 1, 5, 4, 1, 3, 7, 5, 3, 2, 6, 7, 2, 0, 4, 6, 4, 5, 7, 4, 7, 6};
  std::vector<Vec3f> normals{{0, 0, -1}, {0, -1, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, 0, 1}, {0, 0, 1}};

  Cube() {
    for (int i = 0; i < 8; ++i)
      positions.push_back({6.0f + float(i & 1), 8.0f + float(i >> 1 & 1), float(i >> 2)});
  }
  std::vector<Vec3f> at_vertices() const {
    return vertex_normals(positions, {starts, totals, corners, normals});
  }
};

TEST(VertexNormals, ACubesCornersAreDiagonal) {
  const Cube cube;
  const auto found = cube.at_vertices();
  ASSERT_EQ(found.size(), 8u);
  for (size_t i = 0; i < 8; ++i) {
    const Vec3f signs(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
    EXPECT_LT(length(found[i] - signs / std::sqrt(3.0f)), 1e-6f)
        << i;  // the quarter turns to single precision
  }
}

TEST(VertexNormals, WithoutASideItIsTheDirectionOfThePosition) {
  Cube cube;
  cube.positions.push_back({0, 3, 4});  // of no polygon
  cube.normals.assign(7, Vec3f{});      // as of polygons without area
  const auto found = cube.at_vertices();
  EXPECT_LT(length(found[8] - Vec3f(0, 0.6f, 0.8f)), 1e-6f);
  EXPECT_LT(length(found[0] - Vec3f(0.6f, 0.8f, 0)), 1e-6f);
}

TEST(VertexNormals, WhatIsNotThereIsRefused) {
  for (const int32_t wrong : {-1, 8}) {
    Cube cube;
    cube.corners[5] = wrong;
    EXPECT_THROW(cube.at_vertices(), std::out_of_range);
  }
  for (const int32_t wrong : {-1, 24, INT32_MAX}) {
    Cube cube;
    cube.starts[6] = wrong;
    EXPECT_THROW(cube.at_vertices(), std::out_of_range);
  }
  Cube cube;
  cube.totals.pop_back();
  EXPECT_THROW(cube.at_vertices(), std::out_of_range);
}

}  // namespace
}  // namespace penumbra
