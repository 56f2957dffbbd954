// SPDX-License-Identifier: GPL-3.0-or-later
// Groups whose light surface points share by cubes. Oracle: the same group, element by element.
#include <gtest/gtest.h>

#include "luminaire/light_cells.h"
#include "luminaire/light_group.h"
#include "many_luminaires.h"

namespace penumbra {
namespace {

using test::kUnshared;
using test::many;
using test::mean_of_points;
using test::surface_at;
using test::Trials;

/// In units of what the luminaires would send if all of them and the surface faced each other.
TEST(LightCells, LightIsThatOfTheElements) {
  Trials trials(11);
  double worst = 0, mean = 0;
  int shared = 0, count = 0;
  for (int scene = 0; scene < 60; ++scene) {
    const bool one_way = scene % 2;  // as under a ceiling of lamps
    std::vector<Luminaire> luminaires = many(one_way ? 0 : 150, trials, false, false);
    for (int i = 0; one_way && i < 150; ++i)
      luminaires.emplace_back(
          AreaLuminaire{
              "lamp",
              LuminaireShape::kRectangle,
              Affine{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {trials.uniform(-1, 1), trials.uniform(-1, 1), 0}},
              0.05,
              0.03,
              {1, 1, 1}},
          Normalization{});
    const LightTree tree(luminaires);
    const uint32_t root = tree.roots()[0];
    LightCells cells(tree, root, LightChannel::kLargest, 1e-3),
        plain(tree, root, LightChannel::kLargest, kUnshared);
    const double far = trials.uniform(1.2, 8);
    Vec3d at = trials.direction() * far;
    if (one_way) at.z = -std::abs(at.z);
    const Vec3d n = normalize(-at + trials.direction() * (0.7 * far));
    double facing = 0;
    for (const Luminaire& l : luminaires)
      for (const LightElement& e : l.elements()) {
        const Vec3d to_light = e.centre - at;
        facing += max_component(l.radiance()) * e.strength / dot(to_light, to_light);
      }
    for (int i = 0; i < 100; ++i) {
      const SurfacePoint surface =
          surface_at(at + trials.direction() * (0.1 * far * trials.uniform(0, 1)), n);
      const double exact = plain.form_factor(surface), found = cells.form_factor(surface);
      const double error = std::abs(found - exact) / facing;
      worst = std::max(worst, error);
      mean += error;
      shared += found != exact;
      ++count;
    }
  }
  EXPECT_GT(shared, count / 2);
  EXPECT_LT(worst, 1e-3);
  EXPECT_LT(mean / count, 1e-4);
}

TEST(LightCells, APointsLightDoesNotDependOnWhatWasAskedBefore) {
  Trials trials(12);
  const std::vector<Luminaire> luminaires = many(200, trials, false);
  const LightTree tree(luminaires);
  const uint32_t root = tree.roots()[0];
  std::vector<SurfacePoint> surfaces;
  for (int i = 0; i < 200; ++i)
    surfaces.push_back(surface_at(Vec3d{3, 0.5, 1} + trials.direction() * 0.4, {-1, 0, 0}));
  LightCells forward(tree, root, LightChannel::kLargest, 1e-3),
      backward(tree, root, LightChannel::kLargest, 1e-3);
  std::vector<double> found;
  for (const SurfacePoint& s : surfaces) found.push_back(forward.form_factor(s));
  for (size_t i = surfaces.size(); i-- > 0;) EXPECT_EQ(backward.form_factor(surfaces[i]), found[i]);
}

TEST(LightCells, SharedChoicesHaveTheFormFactorAsMean) {
  Trials trials(13);
  const std::vector<Luminaire> luminaires = many(90, trials, false, false);
  const LightTree tree(luminaires);
  std::vector<Luminaire> groups;
  tree.append(tree.roots()[0], 1e-3, groups);
  ASSERT_EQ(groups.size(), 1u);
  LightCells cells(tree, tree.roots()[0], LightChannel::kLargest, 1e-3);
  int shared = 0;
  for (int i = 0; i < 20; ++i) {
    const Vec3d at = trials.direction() * trials.uniform(3, 6);
    const SurfacePoint surface = surface_at(at, normalize(-at + trials.direction() * 0.2));
    shared += cells.choice(surface) != nullptr;
    EXPECT_NEAR(mean_of_points(groups[0], surface, trials) / groups[0].form_factor(surface), 1, 0.01);
  }
  EXPECT_GT(shared, 10);
}

TEST(LightCells, CubesHoldEnoughOfThePoints) {
  std::vector<Vec3d> grid;
  for (int i = 0; i < 64; ++i) grid.push_back({0.1 * (i % 8) + 0.05, 0.1 * (i / 8) + 0.05, 0});
  EXPECT_EQ(shared_cube_side(grid), 0.25);  // of 0.125 there are 49
  EXPECT_EQ(shared_cube_side(std::vector<Vec3d>(3)), kUnshared);
  EXPECT_EQ(shared_cube_side(std::vector<Vec3d>(8)), kUnshared);  // of no extent
  const double alone = shared_cube_side(grid);
  grid.resize(512, grid.back());  // one of them very often
  EXPECT_EQ(shared_cube_side(grid), alone);
  // Next to each other as far as doubles tell: no cube is small enough to part them.
  std::vector<Vec3d> close;
  for (int i = 0; i < 8; ++i) close.push_back({1 + i * 0x1p-52, 1, 1});
  EXPECT_LT(shared_cube_side(close), 1e-14);
}

}  // namespace
}  // namespace penumbra
