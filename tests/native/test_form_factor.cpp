// SPDX-License-Identifier: GPL-3.0-or-later
// The engine's closed forms against other closed forms: the special cases of the rectangle, the disk, the
// point light, and Lambert's formula as oracles.h writes it. Tolerances are those of the atan2 form in
// double.
#include <gtest/gtest.h>

#include "luminaire/form_factor.h"
#include "luminaire/luminaire.h"
#include "math/arc_tangent.h"
#include "oracles.h"

namespace penumbra {
namespace {

using test::kPi;
using test::light;
using test::surface_at;
using test::Trials;

Luminaire rectangle(const Affine& transform, double size_x, double size_y) {
  return Luminaire(light(LuminaireShape::kRectangle, transform, size_x, size_y), {});
}

std::vector<Vec3d> corners(const Affine& t, double size_x, double size_y) {
  const Vec3d u = t.x_axis * (size_x / 2), v = t.y_axis * (size_y / 2);
  return {t.origin - u - v, t.origin + u - v, t.origin + u + v, t.origin - u + v};
}

TEST(FormFactor, CornerOverThePoint) {
  // Parallel rectangle a x b at height h, a corner straight above: X = Y = 1 gives 0.138531606.
  const auto exact = [](double x, double y) {
    const double rx = std::sqrt(1 + x * x), ry = std::sqrt(1 + y * y);
    return (x / rx * std::atan(y / rx) + y / ry * std::atan(x / ry)) / (2 * kPi);
  };
  EXPECT_NEAR(exact(1, 1), 0.138531606, 5e-10);
  for (double a : {1e-3, 1.0, 50.0})
    for (double b : {1e-2, 1.0, 1e4})
      for (double h : {0.1, 1.0, 7.0}) {
        const Luminaire l = rectangle({{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {a / 2, b / 2, h}}, a, b);
        const double f = l.form_factor(surface_at({}, {0, 0, 1})), e = exact(a / h, b / h);
        EXPECT_NEAR(f, e, 1e-11 * e) << a << " x " << b << " at " << h;
      }
}

TEST(FormFactor, WallThatStandsOnTheFloor) {
  // Height a, width b, one end before the point at distance c: a = b = c = 1 gives 0.055734197; from 1e-6 m
  // away E / L_e is 1.5707939 (width 1, the point before its middle).
  const auto wall = [](double a, double b, double c, double aside) {
    const Affine t{{0, 1, 0}, {0, 0, 1}, {1, 0, 0}, {c, aside, a / 2}};  // emits towards -x
    return rectangle(t, b, a).form_factor(surface_at({}, {0, 0, 1}));
  };
  EXPECT_NEAR(wall(1, 1, 1, 0.5), 0.055734197, 5e-10);
  EXPECT_NEAR(kPi * wall(1, 1, 1e-6, 0), 1.5707939, 5e-8);
  for (double a : {0.01, 1.0, 100.0})
    for (double c : {1e-3, 1.0, 30.0}) {
      const double r = std::hypot(a, c), exact = (std::atan(2 / c) - c / r * std::atan(2 / r)) / (2 * kPi);
      EXPECT_NEAR(wall(a, 2, c, 1), exact, 1e-8 * exact) << a << " at " << c;
    }
}

TEST(FormFactor, RandomRectanglesCutByTheHorizon) {
  // The same formula, clipped in another way: 1e-9 (vertices nearly in the horizon lose digits).
  Trials trials(1);
  int cut = 0, lit = 0;
  for (int trial = 0; trial < 20000; ++trial) {
    const Affine t = trials.transform(1);
    const double x = trials.uniform(0.01, 3), y = trials.uniform(0.01, 3);
    const Vec3d point = trials.vector(2), n = trials.direction();
    const Luminaire l = rectangle(t, x, y);
    const SurfacePoint surface = surface_at(point, n);
    const auto polygon = corners(t, x, y);
    Vec3d emitting = normalize(cross(t.x_axis, t.y_axis));
    if (dot(emitting, t.z_axis) > 0) emitting = -emitting;
    const double exact =
        dot(point - t.origin, emitting) > 0 ? test::lambert_form_factor(polygon, point, n) : 0.0;
    ASSERT_NEAR(l.form_factor(surface), exact, 1e-9 * exact + 1e-15) << "trial " << trial;
    ASSERT_EQ(l.form_factor(surface) > 0, !l.unseen_from(surface)) << "trial " << trial;
    lit += exact > 0;
    cut += exact > 0 && test::above_horizon(polygon, point, n) != polygon;
  }
  EXPECT_GT(lit, 3000);
  EXPECT_GT(cut, 2000);
}

TEST(FormFactor, FarAndSmallIsThePointLight) {
  // area cos cos' / (pi r^2), right to (size / r)^2. Relative error of the formula: 1e-3 m at 10 m 6e-12,
  // 1e-6 m at 10 m 1.3e-6 (the arc's tangent cancels).
  Trials trials(2);
  for (const auto& [size, tolerance] : {std::pair{1e-3, 5e-8}, {1e-6, 5e-6}})
    for (int trial = 0; trial < 200; ++trial) {
      const Vec3d n = trials.direction(), way = trials.direction();
      const Affine t = trials.rigid(0);
      const Vec3d at = way * 10.0;
      const double cosines = dot(n, way) * dot(t.z_axis, way);
      if (dot(n, way) < 0.1 || dot(t.z_axis, way) < 0.1) continue;
      const double exact = size * size * cosines / (kPi * 100);
      const double f =
          rectangle({t.x_axis, t.y_axis, t.z_axis, at}, size, size).form_factor(surface_at({}, n));
      EXPECT_NEAR(f, exact, tolerance * exact) << "size " << size << ", trial " << trial;
    }
}

TEST(FormFactor, HugeAndNearFillsTheSky) {
  // 1e4 m wide, 1e-3 m above: all but (h / half)^2 of the hemisphere. Tilted surfaces see (1 + cos) / 2 of
  // it.
  const Luminaire l = rectangle({{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 1e-3}}, 1e4, 1e4);
  EXPECT_NEAR(l.form_factor(surface_at({}, {0, 0, 1})), 1, 1e-12);
  for (double angle : {0.3, 1.0, 1.5})
    EXPECT_NEAR(l.form_factor(surface_at({}, {std::sin(angle), 0, std::cos(angle)})),
                (1 + std::cos(angle)) / 2, 1e-6);
}

TEST(FormFactor, PartsAddUp) {
  // A rectangle cut into 5 x 7 is the sum of its parts, and six around a point inside a box make one.
  Trials trials(3);
  for (int trial = 0; trial < 200; ++trial) {
    const Affine t = trials.rigid(1);
    const Vec3d point = trials.vector(2), n = trials.direction();
    const double whole = rectangle(t, 1, 1).form_factor(surface_at(point, n));
    double sum = 0;
    for (int i = 0; i < 35; ++i) {
      Affine part = t;
      part.origin = t.point({(i % 5 + 0.5) / 5 - 0.5, (i / 5 + 0.5) / 7 - 0.5, 0});
      sum += rectangle(part, 1.0 / 5, 1.0 / 7).form_factor(surface_at(point, n));
    }
    EXPECT_NEAR(sum, whole, 1e-11) << "trial " << trial;

    double around = 0;
    const Vec3d axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, inside = trials.vector(0.9);
    for (int k = 0; k < 6; ++k) {
      const Vec3d out = axes[k / 2] * (k % 2 ? 1.0 : -1.0);
      around += rectangle({axes[(k / 2 + 1) % 3], axes[(k / 2 + 2) % 3], out, out}, 2, 2)
                    .form_factor(surface_at(inside, n));
    }
    EXPECT_NEAR(around, 1, 1e-12) << "trial " << trial;
  }
}

TEST(FormFactor, EllipseCountsAsItsPolygonOfEqualArea) {
  // Disk: relative error 1e-6 from one radius away, as luminaire.h says; 64 sides of equal area.
  for (double height : {1.0, 2.0, 10.0})
    for (double aside : {0.0, 0.5, 1.5, 4.0}) {
      const Luminaire l(light(LuminaireShape::kEllipse, {}, 2, 2), {});
      const double exact = test::disk_form_factor(1, height, aside);
      EXPECT_NEAR(l.form_factor(surface_at({aside, 0, -height}, {0, 0, 1})), exact, 2e-6 * exact)
          << height << " below, " << aside << " aside";
    }
}

TEST(FormFactor, RandomEllipses) {
  // Against a fine inscribed polygon (4e-7 of its area), from two half axes away, horizon included: 1e-5;
  // where the horizon leaves only a sliver, its share of the outline's error grows: 1e-7 absolute.
  Trials trials(4);
  for (int trial = 0; trial < 300; ++trial) {
    const Affine t = trials.rigid(1);
    const double x = trials.uniform(0.2, 1), y = trials.uniform(0.2, 1);
    std::vector<Vec3d> polygon;
    for (int i = 0; i < 4096; ++i) {
      const double a = 2 * kPi * i / 4096;
      polygon.push_back(t.point({std::cos(a) * x / 2, std::sin(a) * y / 2, 0}));
    }
    const Vec3d point = t.origin + trials.direction() * trials.uniform(1, 4), n = trials.direction();
    const double exact =
        dot(point - t.origin, t.z_axis) < 0 ? test::lambert_form_factor(polygon, point, n) : 0.0;
    const double f =
        Luminaire(light(LuminaireShape::kEllipse, t, x, y), {}).form_factor(surface_at(point, n));
    EXPECT_NEAR(f, exact, 1e-5 * exact + 2e-6) << "trial " << trial;
  }
}

TEST(FormFactor, ManyPointsAtOnceAreTheSame) {
  // Above, across and below the horizon, behind the luminaire and in its plane, from 1e-4 to 1e3 sizes away.
  // The angles' polynomial costs 1e-12, the order of subtraction up to 1e-16 / 1e-4 more.
  Trials trials(5);
  for (LuminaireShape shape : {LuminaireShape::kRectangle, LuminaireShape::kEllipse}) {
    for (int trial = 0; trial < 40; ++trial) {
      const AreaLuminaire description = light(shape, trials.transform(1), 0.7, 0.4);
      const Luminaire luminaire(description, {});
      SurfaceColumns columns;
      std::vector<SurfacePoint> points;
      for (uint32_t i = 0; i < kBatch - uint32_t(trial); ++i) {
        const double distance = std::pow(10.0, trials.uniform(-4, 3));
        points.push_back(surface_at(description.world_from_light.origin + trials.direction() * distance,
                                    trials.direction()));
        columns.add(points.back());
      }
      double many[kBatch];
      luminaire.form_factors(columns, many);
      for (size_t i = 0; i < points.size(); ++i) {
        const double one = luminaire.form_factor(points[i]);
        EXPECT_NEAR(many[i], one, 1e-11 * one + 1e-13) << "trial " << trial << ", point " << i;
      }
    }
  }
}

TEST(FormFactor, AnglesOfThePolynomial) {
  for (int i = 0; i <= 20000; ++i) {
    const double angle = kPi * i / 20000, size = std::pow(10.0, i % 13 - 6);
    const double y = std::abs(std::sin(angle)) * size, x = std::cos(angle) * size;
    EXPECT_NEAR(angle_of(y, x), std::atan2(y, x), 1e-12 * std::atan2(y, x)) << angle;
  }
  EXPECT_NEAR(angle_of(1e-200, 1), 1e-200, 1e-212);
  EXPECT_EQ(angle_of(0, 1), 0);
}

TEST(FormFactor, VerticesOnTheHorizon) {
  // A wall whose lower edge lies exactly in the floor's plane, and one with a corner in it: no edge is lost.
  const std::vector<Vec3d> wall{{1, -1, 0}, {1, 1, 0}, {1, 1, 2}, {1, -1, 2}};
  const std::vector<Vec3d> kite{{1, 0, 0}, {1, 1, 1}, {1, 0, 2}, {1, -1, 1}};
  const std::vector<Vec3d> sunk{{1, 0, -1}, {1, 1, 0}, {1, 0, 1}, {1, -1, 0}};
  for (const auto& polygon : {wall, kite, sunk}) {
    std::vector<Vec3d> edges;
    for (size_t i = 0; i < polygon.size(); ++i)
      edges.push_back(polygon[(i + 1) % polygon.size()] - polygon[i]);
    EXPECT_NEAR(polygon_form_factor(polygon, edges, {0, 0, 1}),
                test::lambert_form_factor(polygon, {}, {0, 0, 1}), 1e-14);
    EXPECT_NEAR(polygon_form_factor(polygon, edges, {0, 0, -1}),
                test::lambert_form_factor(polygon, {}, {0, 0, -1}), 1e-14);
  }
}

}  // namespace
}  // namespace penumbra
