// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <numeric>

#include "luminaire/luminaire.h"
#include "oracles.h"
#include "small_scene.h"
#include "visibility/chords.h"
#include "visibility/shadow_rays.h"

namespace penumbra {
namespace {

/// The visible share of a parallelogram's light; NaN where there is none.
double seen_share(Chords& chords, uint32_t count, float offset) {
  const auto sums = chords.sum(count, offset);
  if (!sums) return NAN;
  const ChordSums all = (*sums)[0] + (*sums)[1] + (*sums)[2] + (*sums)[3];
  return all.seen / all.all;
}

/// In render space.
Parallelogram placed(const Geometry& geometry, const Parallelogram& p) {
  const Normalization& n = geometry.normalization();
  return {n.point(p.corner), p.edge_u * n.scale, p.edge_v * n.scale};
}

/// Random leaves in a box over a floor.
Geometry leaves(uint32_t seed, int count, double size) {
  test::Trials trials(seed);
  std::vector<Mesh> meshes{test::quad({-6, -6, 0}, {12, 0, 0}, {0, 12, 0})};
  Mesh mesh;
  mesh.name = "leaves";
  for (int i = 0; i < count; ++i) {
    const Vec3d centre{trials.uniform(-1.5, 1.5), trials.uniform(-1.5, 1.5), trials.uniform(0.1, 1.6)},
        a = trials.direction() * size, b = trials.direction() * size * 0.5;
    const auto first = uint32_t(mesh.positions.size());
    mesh.positions.insert(mesh.positions.end(), {centre - a, centre + b, centre + a, centre - b});
    mesh.triangles.push_back({first, first + 1, first + 2});
    mesh.triangles.push_back({first, first + 2, first + 3});
  }
  meshes.push_back(mesh);
  return test::place(std::move(meshes));
}

/// Oracle: Lambert's formula of the part that a screen leaves of the luminaire, in double. The screen's edges
/// are the luminaire's, so that what it hides of each chord is exact, and the chords are 1280: what is
/// between them is below 1e-6.
TEST(Chords, LightOfAHalfHiddenRectangleIsLamberts) {
  const Vec3d corner{-1, -0.5, 2}, u{1.5, 0, 0}, v{0, 1.2, 0};
  test::Trials trials(5);
  for (int trial = 0; trial < 20; ++trial) {
    const double share = trials.uniform(0.1, 0.9);
    // Half way up, it hides from the point at the origin s < share.
    const Geometry geometry =
        test::place({test::quad({-6, -6, -0.5}, {12, 0, 0}, {0, 12, 0}),
                     test::quad(corner * 0.5 - u * 2 - v * 2, u * (2 + share / 2), v * 4)});
    Vec3d normal = trials.direction();
    normal.z = std::abs(normal.z) + 0.2;
    normal = normalize(normal);
    const SurfacePoint surface = test::surface_at(geometry.normalization().point({0, 0, 0}), normal);
    const auto view = LuminaireView::from(surface, placed(geometry, {corner, u, v}), float(share));
    ASSERT_TRUE(view);
    Chords chords;
    ASSERT_TRUE(chords.look(*geometry.occluders(), *view, 1000));
    EXPECT_GE(chords.occluders(), 1u);
    ChordSums sums;
    for (int set = 0; set < 10; ++set) {
      const auto parts = chords.sum(Chords::kMost, (float(set) + 0.5f) / 10);
      ASSERT_TRUE(parts);
      for (const ChordSums& part : *parts) sums = sums + part;
    }
    const Vec3d cut = corner + u * share;
    const double all =
                     test::lambert_form_factor({corner, corner + u, corner + u + v, corner + v}, {}, normal),
                 seen = test::lambert_form_factor({cut, corner + u, corner + u + v, cut + v}, {}, normal);
    EXPECT_NEAR(sums.seen / sums.all, seen / all, 2e-5) << share;
  }
}

/// Oracle: Embree's robust rays to 2^16 points of the luminaire each, weighted by the luminaire's own
/// summands. Owen-scrambled nets of n points and K chords miss by n^-3/4 and K^-3/2 or so: 2e-4 and 3e-4 at
/// most.
TEST(Chords, AgreeWithDenseRaysAmongLeaves) {
  const Geometry geometry = leaves(11, 150, 0.25);
  const Normalization& n = geometry.normalization();
  const AreaLuminaire description = test::light(
      LuminaireShape::kRectangle, {{1, 0, 0}, {0, 0.9, 0.2}, {0, -0.2, 0.9}, {0.5, 0.3, 4}}, 1.6, 1.2);
  const Luminaire luminaire(description, n);
  const auto sampler = make_sampler({.samples_per_stream = 1 << 16});
  test::Trials trials(12);
  int partly = 0;
  for (int trial = 0; trial < 60; ++trial) {
    SurfacePoint surface;
    const Vec3d from{trials.uniform(-1.5, 1.5), trials.uniform(-1.5, 1.5), 3};
    ASSERT_TRUE(test::first_surface(geometry, from, {0, 0, -1}, surface));
    const auto view = LuminaireView::from(surface, *luminaire.emitter().parallelogram(), float(trial) / 60);
    ASSERT_TRUE(view);
    Chords chords;
    ASSERT_TRUE(chords.look(*geometry.occluders(), *view, 10000));
    const double by_chords = (seen_share(chords, 128, 0.25f) + seen_share(chords, 128, 0.75f)) / 2;
    const ShadowRays rays(geometry, surface);
    double all = 0, seen = 0;
    alignas(64) float u[kBatch], v[kBatch], visible[kBatch];
    alignas(64) int traced[kBatch];
    LightPoints points;
    for (uint32_t i = 0; i < 1 << 16; i += kBatch) {
      sampler->points({uint64_t(trial), uint64_t(trial) * 7919}, i, kBatch, u, v);
      luminaire.evaluate(surface, u, v, kBatch, points);
      std::copy_n(points.form_factor, kBatch, visible);
      rays.hide(kBatch, points.x, points.y, points.z, visible, traced);
      all += std::accumulate(points.form_factor, points.form_factor + kBatch, 0.0);
      seen += std::accumulate(visible, visible + kBatch, 0.0);
    }
    EXPECT_NEAR(by_chords, seen / all, 1e-3) << trial;
    partly += seen > 0.02 * all && seen < 0.98 * all;
  }
  EXPECT_GT(partly, 25);
}

/// Neighbours' shared edges leave no gap: a luminaire behind a wall of many slivers is not seen at all.
TEST(Chords, NothingPassesBetweenNeighbours) {
  Mesh wall;
  wall.name = "wall";
  test::Trials trials(3);
  constexpr uint32_t kColumns = 60, kRows = 40;
  for (uint32_t j = 0; j <= kRows; ++j)
    for (uint32_t i = 0; i <= kColumns; ++i)
      wall.positions.push_back({-3 + 6.0 * i / kColumns + trials.uniform(-0.04, 0.04),
                                -3 + 6.0 * j / kRows + trials.uniform(-0.06, 0.06),
                                1 + trials.uniform(-0.3, 0.3)});
  for (uint32_t j = 0; j < kRows; ++j)
    for (uint32_t i = 0; i < kColumns; ++i) {
      const uint32_t a = j * (kColumns + 1) + i, b = a + kColumns + 1;
      wall.triangles.push_back({a, a + 1, b + 1});
      wall.triangles.push_back({a, b + 1, b});
    }
  const Geometry geometry = test::place({test::quad({-6, -6, 0}, {12, 0, 0}, {0, 12, 0}), wall});
  for (int trial = 0; trial < 40; ++trial) {
    SurfacePoint surface;
    ASSERT_TRUE(test::first_surface(geometry, {trials.uniform(-1, 1), trials.uniform(-1, 1), 0.3}, {0, 0, -1},
                                    surface));
    const auto view =
        LuminaireView::from(surface, placed(geometry, {{-1, -1, 4}, {2, 0, 0}, {0, 2, 0}}), 0.4f);
    ASSERT_TRUE(view);
    Chords chords;
    ASSERT_TRUE(chords.look(*geometry.occluders(), *view, 100000));
    EXPECT_GT(chords.occluders(), 30u);
    EXPECT_EQ(seen_share(chords, 128, 0.3f), 0) << trial;
  }
}

/// Where what is in the way is not still, opaque triangles that each ray meets, there is no tree of them.
TEST(Chords, OnlyStillOpaqueTrianglesHaveATree) {
  const Mesh floor = test::quad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0});
  const auto with = [&](auto change) {
    std::vector<Mesh> meshes{floor};
    std::vector<Instance> instances{{"a", 0, {}, {0}}};
    uint64_t limit = 0;
    change(meshes, instances, limit);
    return Geometry(std::move(meshes), std::move(instances), limit).occluders() != nullptr;
  };
  EXPECT_TRUE(with([](auto&, auto&, auto&) {}));
  EXPECT_TRUE(with([](auto&, auto& instances, auto&) { instances[0].rays = kShadowRay; }));
  EXPECT_FALSE(with([](auto&, auto& instances, auto&) { instances[0].rays = kCameraRay; }));
  EXPECT_FALSE(with([](auto&, auto& instances, auto&) { instances.push_back(instances[0]); }));
  EXPECT_FALSE(with([](auto&, auto& instances, auto&) {
    instances[0].motion = {Affine{}, Affine{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 0}}};
  }));
  EXPECT_FALSE(with([](auto&, auto&, auto& limit) { limit = 1 << 30; }));
}

/// A smooth normal that looks at a luminaire across the surface's own plane: rays start on either side,
/// chords can't. A flat surface is lit by what is above it alone.
TEST(Chords, ViewsAcrossTheSurfacesPlaneAreRefused) {
  const Parallelogram luminaire{{-1, -1, -1}, {2, 0, 0}, {0, 0, 2}};
  SurfacePoint surface = test::surface_at({0, 2, 0}, {0, 0, 1});
  EXPECT_TRUE(LuminaireView::from(surface, luminaire, 0.5f));
  surface.normal = normalize(Vec3d{0, -1, 2});
  EXPECT_FALSE(LuminaireView::from(surface, luminaire, 0.5f));
  surface = test::surface_at({0, 2e9, 0}, {0, 0, 1});
  EXPECT_FALSE(LuminaireView::from(surface, luminaire, 0.5f)) << "beyond single precision";
}

/// As many as there may be, and not one more.
TEST(Chords, LooksForSoManyOccludersAtMost) {
  const Geometry geometry = leaves(21, 400, 0.1);
  SurfacePoint surface;
  ASSERT_TRUE(test::first_surface(geometry, {0.1, 0.2, 0.05}, {0, 0, -1}, surface));
  const auto view = LuminaireView::from(surface, placed(geometry, {{-1, -1, 4}, {2, 0, 0}, {0, 2, 0}}), 0.4f);
  ASSERT_TRUE(view);
  Chords chords;
  ASSERT_TRUE(chords.look(*geometry.occluders(), *view, 800));
  const uint32_t found = chords.occluders();
  ASSERT_GT(found, 2u);
  EXPECT_TRUE(chords.look(*geometry.occluders(), *view, found));
  EXPECT_FALSE(chords.look(*geometry.occluders(), *view, found - 1));
}

}  // namespace
}  // namespace penumbra
