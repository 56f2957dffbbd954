// SPDX-License-Identifier: GPL-3.0-or-later
// Long triangles in pieces: the same surface without gaps. Oracles: areas; how often edges are used; rays
// against the triangles themselves, in double.
#include <gtest/gtest.h>

#include <map>

#include "oracles.h"
#include "small_scene.h"
#include "visibility/long_triangles.h"

namespace penumbra {
namespace {

using Triangles = std::vector<std::array<uint32_t, 3>>;

const Triangles kSides{{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                       {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};

/// A box along three perpendicular directions.
std::vector<Vec3d> corners_of(const Vec3d& x, const Vec3d& y, const Vec3d& z) {
  std::vector<Vec3d> corners;
  for (int i = 0; i < 8; ++i)
    corners.push_back(x * (i & 1 ? 1 : -1) + y * (i & 2 ? 1 : -1) + z * (i & 4 ? 1 : -1));
  return corners;
}

std::vector<Vec3d> slanted_wire() {
  const Vec3d x = normalize(Vec3d{1, 0.8, 0.3}), y = normalize(cross(x, {0, 0, 1}));
  return corners_of(x, y * 0.004, cross(x, y) * 0.004);
}

std::vector<Vec3f> rounded(const std::vector<Vec3d>& positions) {
  return {positions.begin(), positions.end()};
}

double area(const std::vector<Vec3f>& p, const std::array<uint32_t, 3>& t) {
  return length(cross(Vec3d(p[t[1]]) - Vec3d(p[t[0]]), Vec3d(p[t[2]]) - Vec3d(p[t[0]]))) / 2;
}

TEST(LongTriangles, PiecesCoverTheirTriangles) {
  std::vector<Vec3f> positions = rounded(slanted_wire());
  const TrianglePieces pieces = split_long_triangles(positions, kSides);
  ASSERT_EQ(pieces.corners.size(), pieces.whole.size());
  EXPECT_GT(pieces.corners.size(), 3 * kSides.size());
  EXPECT_LT(pieces.corners.size(), 24 * kSides.size());
  std::vector<double> sums(kSides.size(), 0);
  for (size_t i = 0; i < pieces.corners.size(); ++i)
    sums[pieces.whole[i]] += area(positions, pieces.corners[i]);
  // Middles are rounded to 2^-25 of a length of 2; a strip 0.008 wide changes by 4e-6 of its area.
  for (size_t t = 0; t < kSides.size(); ++t)
    EXPECT_NEAR(sums[t] / area(positions, kSides[t]), 1, 4e-5) << "triangle " << t;
}

TEST(LongTriangles, ClosedMeshesStayClosed) {
  // Each edge is used once in each direction.
  std::vector<Vec3f> positions = rounded(slanted_wire());
  std::map<std::pair<uint32_t, uint32_t>, int> uses;
  for (const auto& t : split_long_triangles(positions, kSides).corners)
    for (int k = 0; k < 3; ++k) ++uses[{t[k], t[(k + 1) % 3]}];
  ASSERT_FALSE(uses.empty());
  for (const auto& [edge, count] : uses) {
    EXPECT_EQ(count, 1);
    EXPECT_TRUE(uses.contains({edge.second, edge.first})) << edge.first << " to " << edge.second;
  }
}

TEST(LongTriangles, OthersStayAsTheyAre) {
  const auto is_split = [](const std::vector<Vec3d>& corners) {
    std::vector<Vec3f> positions = rounded(corners);
    const size_t before = positions.size();
    const bool split = !split_long_triangles(positions, kSides).corners.empty();
    EXPECT_EQ(split, positions.size() > before);
    return split;
  };
  EXPECT_TRUE(is_split(slanted_wire()));
  EXPECT_FALSE(is_split(corners_of({1, 0, 0}, {0, 0.004, 0}, {0, 0, 0.004}))) << "along an axis";
  const Vec3d x = normalize(Vec3d{1, 0.8, 0.3}), y = normalize(cross(x, {0, 0, 1}));
  EXPECT_FALSE(is_split(corners_of(x, y, cross(x, y)))) << "a cube, turned";
}

TEST(LongTriangles, RaysMeetTheTriangleThatTheyWereBefore) {
  Mesh wire;
  wire.name = "wire";
  wire.positions = slanted_wire();
  wire.triangles = kSides;
  for (uint32_t i = 0; i < kSides.size(); ++i) wire.material_slots.push_back(i);
  const std::vector<Vec3d> corners = wire.positions;
  std::vector<uint32_t> materials;
  for (uint32_t i = 0; i < kSides.size(); ++i) materials.push_back(i);
  // Once as it is, once as an instance with a BVH of its own.
  for (uint32_t copies : {1u, 2u}) {
    std::vector<Instance> instances{{"wire", 0, {}, materials}};
    if (copies == 2)
      instances.push_back({"far", 0, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {50, 0, 0}}, materials});
    const Geometry geometry({wire}, std::move(instances));
    const Normalization& n = geometry.normalization();
    test::Trials trials(11);
    int hits = 0;
    for (int i = 0; i < 20000; ++i) {
      const Vec3d axis = normalize(Vec3d{1, 0.8, 0.3}) * trials.uniform(-0.95, 0.95);
      const Vec3d origin = axis + trials.direction() * 2, target = axis + trials.direction() * 0.003;
      // The nearest of the triangles by signed volumes.
      double nearest = 1e30;
      uint32_t expected = Hit::kNone;
      double margin = 1e30;  // how near the ray passes any edge of what it meets
      for (uint32_t t = 0; t < kSides.size(); ++t) {
        const Vec3d a = corners[kSides[t][0]], b = corners[kSides[t][1]], c = corners[kSides[t][2]],
                    d = target - origin, normal = cross(b - a, c - a);
        const double distance = dot(normal, a - origin) / dot(normal, d);
        const Vec3d p = origin + d * distance;
        const double whole = dot(normal, normal);
        const double u = dot(normal, cross(b - a, p - a)) / whole,
                     v = dot(normal, cross(c - b, p - b)) / whole,
                     w = dot(normal, cross(a - c, p - c)) / whole;
        margin = std::min(margin, std::abs(std::min({u, v, w})));
        if (u >= 0 && v >= 0 && w >= 0 && distance > 0 && distance < nearest)
          nearest = distance, expected = t;
      }
      if (margin < 1e-3) continue;  // single precision may tell otherwise
      const Ray ray{n.point(origin), (target - origin) * n.scale, 0, 10};
      Hit hit;
      geometry.intersect(&ray, 1, &hit);
      ASSERT_EQ(hit.found(), expected != Hit::kNone);
      if (!hit.found()) continue;
      ++hits;
      EXPECT_EQ(hit.triangle, expected);
      EXPECT_EQ(geometry.material_of(hit), expected);
    }
    EXPECT_GT(hits, 5000);
  }
}

}  // namespace
}  // namespace penumbra
