// SPDX-License-Identifier: GPL-3.0-or-later
// Triangles without area and copies: oracle is a comparison of all pairs.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "visibility/useless_triangles.h"

namespace penumbra {
namespace {

bool copy_of(const Mesh& m, size_t i, size_t k) {
  std::array<Vec3d, 3> a, b;
  for (int c = 0; c < 3; ++c) a[c] = m.positions[m.triangles[i][c]], b[c] = m.positions[m.triangles[k][c]];
  return std::is_permutation(a.begin(), a.end(), b.begin());
}

/// Few places, so that many triangles coincide; slots and normals tell which ones were kept.
Mesh random_mesh(std::mt19937& random, size_t triangles) {
  Mesh m;
  m.name = "random";
  std::uniform_int_distribution<int> place(-1, 1), index(0, 19);
  for (int i = 0; i < 20; ++i)
    m.positions.push_back({double(place(random)), -0.0 * place(random), double(place(random))});
  for (uint32_t i = 0; i < triangles; ++i) {
    m.triangles.push_back({uint32_t(index(random)), uint32_t(index(random)), uint32_t(index(random))});
    m.material_slots.push_back(i);
    for (int c = 0; c < 3; ++c) m.corner_normals.push_back({float(i), float(c), 0});
  }
  return m;
}

TEST(UselessTriangles, AreThoseThatAllPairsTell) {
  std::mt19937 random(5);
  for (int trial = 0; trial < 50; ++trial) {
    const Mesh before = random_mesh(random, 200);
    Mesh after = before;
    const UselessTriangles found = remove_useless_triangles(after);
    std::vector<uint32_t> expected;
    size_t without_area = 0;
    for (size_t i = 0; i < before.triangles.size(); ++i) {
      const auto& t = before.triangles[i];
      const Vec3d& a = before.positions[t[0]];
      const bool flat = cross(before.positions[t[1]] - a, before.positions[t[2]] - a) == Vec3d{};
      without_area += flat;
      bool copy = false;
      for (size_t k = 0; k < i; ++k) copy = copy || copy_of(before, i, k);
      if (!flat && !copy) expected.push_back(uint32_t(i));
    }
    EXPECT_EQ(found.without_area, without_area);
    EXPECT_EQ(found.copies, before.triangles.size() - without_area - expected.size());
    EXPECT_GT(found.copies, 10u);
    ASSERT_EQ(after.material_slots, expected);
    for (size_t i = 0; i < expected.size(); ++i) {
      EXPECT_EQ(after.triangles[i], before.triangles[expected[i]]);
      for (int c = 0; c < 3; ++c)
        EXPECT_EQ(after.corner_normals[3 * i + c], before.corner_normals[3 * expected[i] + c]);
    }
  }
}

/// Some of 200,000 triangles once more: with vertices of their own, in another order, after all others.
TEST(UselessTriangles, FewCopiesAreFoundAmongMany) {
  std::mt19937 random(6);
  Mesh m;
  constexpr uint32_t kTriangles = 200'000, kCopies = 300;
  std::uniform_real_distribution<double> place(-1, 1);
  for (uint32_t i = 0; i < kTriangles + 2; ++i)
    m.positions.push_back({place(random), place(random), place(random)});
  for (uint32_t i = 0; i < kTriangles; ++i) m.triangles.push_back({i, i + 1, i + 2});
  const auto before = m.triangles;
  for (uint32_t k = 0; k < kCopies; ++k) {
    const auto& t = before[k * (kTriangles / kCopies)];
    const auto first = uint32_t(m.positions.size());
    for (int c = 0; c < 3; ++c) m.positions.push_back(Vec3d(m.positions[t[c]]));
    m.triangles.push_back(k % 2 ? std::array{first + 1, first, first + 2}
                                : std::array{first + 2, first, first + 1});
  }
  const UselessTriangles found = remove_useless_triangles(m);
  EXPECT_EQ(found.copies, kCopies);
  EXPECT_EQ(found.without_area, 0u);
  EXPECT_EQ(m.triangles, before);
}

TEST(UselessTriangles, SoundMeshesAreLeftAlone) {
  Mesh strip;
  for (int i = 0; i < 5002; ++i) strip.positions.push_back({double(i / 2), double(i % 2), 1e-9 * i});
  for (uint32_t i = 0; i < 5000; ++i) strip.triangles.push_back({i, i + 1, i + 2});
  const auto before = strip.triangles;
  EXPECT_EQ(remove_useless_triangles(strip).count(), 0u);
  EXPECT_EQ(strip.triangles, before);
  Mesh empty;
  EXPECT_EQ(remove_useless_triangles(empty).count(), 0u);
}

}  // namespace
}  // namespace penumbra
