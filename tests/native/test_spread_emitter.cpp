// SPDX-License-Identifier: GPL-3.0-or-later
// Area lights of some spread. Oracle: area x cos cos' / (pi r^2) x the fall over small patches, in double.
#include <gtest/gtest.h>

#include "luminaire/luminaire.h"
#include "oracles.h"

namespace penumbra {
namespace {

using test::kPi;
using test::light;
using test::surface_at;
using test::Trials;

double brute_force(const AreaLuminaire& l, const Vec3d& point, const Vec3d& n, int side) {
  const Affine& t = l.world_from_light;
  const Vec3d across = cross(t.x_axis * l.size_x, t.y_axis * l.size_y);
  Vec3d normal = normalize(across);
  if (dot(normal, t.z_axis) > 0) normal = -normal;
  const double h = l.spread / 2, area = length(across) / (double(side) * side);
  double sum = 0;
  for (int i = 0; i < side; ++i)
    for (int j = 0; j < side; ++j) {
      const double s = (i + 0.5) / side - 0.5, v = (j + 0.5) / side - 0.5;
      if (l.shape == LuminaireShape::kEllipse && s * s + v * v > 0.25) continue;
      const Vec3d d = t.point({s * l.size_x, v * l.size_y, 0}) - point;
      const double r = length(d), above = dot(d, n) / r, front = -dot(d, normal) / r;
      if (above <= 0 || front <= 0) continue;
      const double fall =
          (1 - std::tan(std::acos(std::min(front, 1.0))) / std::tan(h)) / (1 - h / std::tan(h));
      if (fall > 0) sum += area * above * front * fall / (kPi * r * r);
    }
  return sum;
}

TEST(Spread, FormFactorIsTheIntegral) {
  // 600 x 600 patches and 32 x 32 points, with kinks at the cone's edge and steps at an ellipse's: 1e-2 of
  // the whole where the light is seen face on, and as much for its edge.
  Trials trials(51);
  int lit = 0, dark = 0;
  for (int trial = 0; trial < 60; ++trial) {
    AreaLuminaire l = light(trial % 2 ? LuminaireShape::kRectangle : LuminaireShape::kEllipse,
                            trial % 3 ? trials.rigid(1) : trials.transform(1), trials.uniform(0.3, 1),
                            trials.uniform(0.3, 1));
    l.spread = trials.uniform(0.3, 3.0);
    const Affine& t = l.world_from_light;
    const Vec3d point = t.point({trials.uniform(-1, 1), trials.uniform(-1, 1), -2}),
                n = normalize(normalize(t.origin - point) + trials.direction() * 0.5);
    const Luminaire luminaire(l, {});
    const double exact = brute_force(l, point, n, 600), f = luminaire.form_factor(surface_at(point, n));
    EXPECT_NEAR(f, exact, 1e-2 * exact + 1e-4) << "trial " << trial;
    if (luminaire.unseen_from(surface_at(point, n))) {
      EXPECT_EQ(exact, 0) << "trial " << trial;
    }
    lit += exact > 0.01;
    dark += exact == 0;
  }
  EXPECT_GT(lit, 15);
  EXPECT_GT(dark, 3);
}

TEST(Spread, HalfTheSkyIsTheFlatLight) {
  // The limit: at pi - 2e-3 the fall takes 1e-3 of a light that is seen within 45 degrees.
  AreaLuminaire l = light(LuminaireShape::kRectangle, {}, 1, 1);
  const SurfacePoint below = surface_at({0.3, 0.1, -1.5}, {0, 0, 1});
  const double flat = Luminaire(l, {}).form_factor(below);
  l.spread = kPi - 2e-3;
  EXPECT_NEAR(Luminaire(l, {}).form_factor(below), flat, 3e-3 * flat);
}

}  // namespace
}  // namespace penumbra
