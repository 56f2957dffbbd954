// SPDX-License-Identifier: GPL-3.0-or-later
// Oracles: Lambert's polygon formula with horizon clipping and the disk's form factor, in double (oracles.h).
#include <gtest/gtest.h>

#include "luminaire/flat_emitter.h"
#include "luminaire/luminaire.h"
#include "oracles.h"

namespace penumbra {
namespace {

using test::kPi;
using test::light;
using test::surface_at;
using test::Trials;

std::vector<Vec3d> corners(const AreaLuminaire& l) {
  std::vector<Vec3d> c;
  for (auto [s, t] : {std::pair{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}})
    c.push_back(l.world_from_light.point({s * l.size_x, t * l.size_y, 0}));
  return c;
}

/// On the side that emits: opposite to where the local z axis points.
bool in_front(const AreaLuminaire& l, const Vec3d& point) {
  const Affine& t = l.world_from_light;
  Vec3d n = cross(t.x_axis, t.y_axis);
  if (dot(n, t.z_axis) > 0) n = -n;
  return dot(point - t.origin, n) > 0;
}

/// Mean of form_factor over the centres of n x n equal cells of the unit square: the midpoint rule.
double midpoint_form_factor(const Luminaire& luminaire, const SurfacePoint& surface, int n) {
  double sum = 0;
  alignas(64) float u[kBatch], v[kBatch];
  LightPoints points;
  uint32_t filled = 0;
  const auto flush = [&] {
    for (uint32_t i = filled; i < kBatch; ++i) u[i] = v[i] = 0.5f;
    luminaire.evaluate(surface, u, v, kBatch, points);
    for (uint32_t i = 0; i < filled; ++i) sum += double(points.form_factor[i]);
    filled = 0;
  };
  for (int i = 0; i < n * n; ++i) {
    u[filled] = float((i % n + 0.5) / n);
    v[filled] = float((i / n + 0.5) / n);
    if (++filled == kBatch) flush();
  }
  flush();
  return sum / (double(n) * n);
}

/// Of flat luminaires, which have their own loop, and of others.
TEST(Luminaire, PointsForEachSurfaceAreThosePointsForOne) {
  Trials trials(6);
  AreaLuminaire narrow = light(LuminaireShape::kRectangle, trials.transform(1), 0.7, 0.4);
  narrow.spread = 2;
  const AreaLuminaire wide = light(LuminaireShape::kRectangle, trials.transform(1), 0.7, 0.4),
                      round = light(LuminaireShape::kEllipse, trials.transform(1), 0.7, 0.4);
  for (const auto& [description, points] : {std::pair{narrow, 4u}, {wide, 1u}, {wide, 4u}, {round, 4u}}) {
    const Luminaire luminaire(description, {});
    SurfaceColumns columns;
    std::vector<SurfacePoint> surfaces;
    alignas(64) float u[kBatch], v[kBatch];
    for (uint32_t i = 0; i < kBatch; ++i) {
      u[i] = float(trials.uniform(0, 1)), v[i] = float(trials.uniform(0, 1));
      if (i >= kBatch / points) continue;
      surfaces.push_back(surface_at(trials.vector(4), trials.direction()));
      columns.add(surfaces.back());
    }
    LightPoints each, one;
    luminaire.evaluate_each(columns, u, v, each, points);
    for (uint32_t i = 0; i < kBatch; ++i) {
      luminaire.evaluate(surfaces[i % surfaces.size()], &u[i], &v[i], 1, one);
      EXPECT_EQ(each.x[i], one.x[0]);
      EXPECT_EQ(each.y[i], one.y[0]);
      EXPECT_EQ(each.z[i], one.z[0]);
      EXPECT_EQ(each.form_factor[i], one.form_factor[0]);
    }
  }
}

TEST(Luminaire, MeanFormFactorIsLambertsForRandomRectangles) {
  // Midpoint rule with 256 x 256 cells, points at least 0.7 of the luminaire's size away: its error falls as
  // 1/n^2 where the integrand is smooth (1e-5) and, where the horizon cuts the luminaire, as a kink's: 1/n^2
  // as well since the integrand is continuous there. 2e-4 of the form factor, plus 1e-7 for the slimmest
  // ones.
  Trials trials(1);
  int lit = 0, cut = 0;
  for (int trial = 0; trial < 400; ++trial) {
    const AreaLuminaire l = light(LuminaireShape::kRectangle, trials.transform(0.5), trials.uniform(0.2, 1),
                                  trials.uniform(0.2, 1));
    const Vec3d point = l.world_from_light.origin + trials.direction() * trials.uniform(2, 6),
                n = trials.direction();
    const double exact = in_front(l, point) ? test::lambert_form_factor(corners(l), point, n) : 0.0;
    const double mean = midpoint_form_factor(Luminaire(l, {}), surface_at(point, n), 256);
    EXPECT_NEAR(mean, exact, 2e-4 * exact + 1e-7) << "trial " << trial;
    lit += exact > 0;
    cut += exact > 0 && test::above_horizon(corners(l), point, n) != corners(l);
  }
  EXPECT_GT(lit, 60);  // a quarter of all on average
  EXPECT_GT(cut, 10);
}

TEST(Luminaire, NormalizationLeavesFormFactorsAlone) {
  // The same luminaire 1e6 m away and a million times smaller: render space is the same to double rounding of
  // the offset, 1e6 * 2^-53 / 1e-6 = 1e-4 of the luminaire's size; positions chosen as multiples of 2^-30 are
  // exact.
  const double tiny = 0x1p-20;
  const Affine t{{tiny, 0, 0}, {0, tiny, 0}, {0, 0, tiny}, {0x1p20, -0x1p20, 0x1p19}};
  const Luminaire moved(light(LuminaireShape::kRectangle, t, 1, 2), {t.origin, 0x1p20});
  const Luminaire plain(light(LuminaireShape::kRectangle, {}, 1, 2), {});
  const SurfacePoint surface = surface_at({0.25, 0.5, -1.5}, normalize(Vec3d{0.1, 0.2, 1}));
  EXPECT_EQ(midpoint_form_factor(moved, surface, 16), midpoint_form_factor(plain, surface, 16));
}

TEST(Luminaire, EllipseWithEqualAxesIsTheDisk) {
  // The map from square to disk keeps areas, so the midpoint rule holds; the integrand in (u, v) has kinks on
  // the diagonals: 1e-4.
  for (double radius : {0.1, 0.5, 2.0})
    for (double height : {0.5, 1.0, 3.0})
      for (double aside : {0.0, 0.4, 2.5}) {
        const Luminaire l(light(LuminaireShape::kEllipse, {}, 2 * radius, 2 * radius), {});
        const double mean = midpoint_form_factor(l, surface_at({aside, 0, -height}, {0, 0, 1}), 256);
        const double exact = test::disk_form_factor(radius, height, aside);
        EXPECT_NEAR(mean, exact, 1e-4 * exact) << radius << " " << height << " " << aside;
      }
}

TEST(Luminaire, EllipseIsTheLimitOfItsPolygons) {
  // Inscribed polygon of 4096 corners: its area falls short by (2 pi / 4096)^2 / 6 = 4e-7. Midpoint rule:
  // 2e-4.
  Trials trials(2);
  for (int trial = 0; trial < 40; ++trial) {
    const AreaLuminaire l = light(LuminaireShape::kEllipse, trials.transform(0.5), trials.uniform(0.2, 1),
                                  trials.uniform(0.2, 1));
    std::vector<Vec3d> polygon;
    for (int i = 0; i < 4096; ++i) {
      const double a = 2 * kPi * i / 4096;
      polygon.push_back(
          l.world_from_light.point({std::cos(a) * l.size_x / 2, std::sin(a) * l.size_y / 2, 0}));
    }
    const Vec3d point = l.world_from_light.origin + trials.direction() * trials.uniform(2, 5),
                n = trials.direction();
    const double exact = in_front(l, point) ? test::lambert_form_factor(polygon, point, n) : 0.0;
    EXPECT_NEAR(midpoint_form_factor(Luminaire(l, {}), surface_at(point, n), 256), exact,
                2e-4 * exact + 1e-7);
  }
}

TEST(Luminaire, EmitsTowardsLocalMinusZOnly) {
  // Also where the transform mirrors or shears: above means on the side that local +z points to.
  Trials trials(3);
  for (int trial = 0; trial < 200; ++trial) {
    const AreaLuminaire l = light(LuminaireShape::kRectangle, trials.transform(1), 1, 1);
    const Vec3d inside = l.world_from_light.point({0.1, -0.2, 0}), z = l.world_from_light.z_axis;
    const Luminaire luminaire(l, {});
    const SurfacePoint behind = surface_at(inside + z, normalize(-z)),
                       before = surface_at(inside - z, normalize(z));
    EXPECT_TRUE(luminaire.unseen_from(behind));
    EXPECT_EQ(midpoint_form_factor(luminaire, behind, 8), 0.0);
    EXPECT_FALSE(luminaire.unseen_from(before));
    EXPECT_GT(midpoint_form_factor(luminaire, before, 8), 0.0);
    // Facing away from it.
    EXPECT_EQ(midpoint_form_factor(luminaire, surface_at(inside - z * 3.0, normalize(-z)), 8), 0.0);
  }
}

TEST(Luminaire, NoLightInItsOwnPlaneAndNoNaN) {
  const Luminaire l(light(LuminaireShape::kRectangle, {}, 1, 1), {});
  for (const Vec3d& p : {Vec3d{0, 0, 0}, Vec3d{0.5, 0.5, 0}, Vec3d{2, 0, 0}, Vec3d{-0.5, 0.25, 0}})
    for (const Vec3d& n : {Vec3d{0, 0, 1}, Vec3d{0, 0, -1}, Vec3d{1, 0, 0}}) {
      EXPECT_TRUE(l.unseen_from(surface_at(p, n)));
      EXPECT_EQ(midpoint_form_factor(l, surface_at(p, n), 9),
                0.0);  // 9: the middle cell's centre is the light's
    }
}

TEST(Luminaire, UnseenFromIsNeverWrong) {
  // Whenever the closed form is positive the luminaire must not be called unseen; and where its parallelogram
  // is wholly behind or below, it must be (that is what saves the rays).
  Trials trials(4);
  int unseen = 0;
  for (int trial = 0; trial < 20000; ++trial) {
    const AreaLuminaire l = light(LuminaireShape::kRectangle, trials.transform(1), trials.uniform(0.01, 3),
                                  trials.uniform(0.01, 3));
    const Vec3d point = trials.vector(2), n = trials.direction();
    const double exact = in_front(l, point) ? test::lambert_form_factor(corners(l), point, n) : 0.0;
    const bool called_unseen = Luminaire(l, {}).unseen_from(surface_at(point, n));
    ASSERT_EQ(called_unseen, exact == 0) << "trial " << trial << ", F = " << exact;
    unseen += called_unseen;
  }
  EXPECT_GT(unseen, 2000);
  EXPECT_LT(unseen, 18000);
}

TEST(Luminaire, AreaIsThatOfTheTransformedShape) {
  // Rectangle: two triangles by Heron's formula. Ellipse: pi / 4 of it, since affine maps keep ratios of
  // areas.
  Trials trials(5);
  const auto triangle = [](const Vec3d& a, const Vec3d& b, const Vec3d& c) {
    const double x = length(b - a), y = length(c - b), z = length(a - c), s = (x + y + z) / 2;
    return std::sqrt(std::max(0.0, s * (s - x) * (s - y) * (s - z)));
  };
  for (int trial = 0; trial < 500; ++trial) {
    const AreaLuminaire l = light(LuminaireShape::kRectangle, trials.transform(3), trials.uniform(0.1, 4),
                                  trials.uniform(0.1, 4));
    const auto c = corners(l);
    const double exact = triangle(c[0], c[1], c[2]) + triangle(c[0], c[2], c[3]);
    // Heron's formula loses digits in flat triangles: 1e-9.
    EXPECT_NEAR(area_of(LuminaireShape::kRectangle, l.world_from_light, l.size_x, l.size_y), exact,
                1e-9 * exact + 1e-12);
    EXPECT_NEAR(area_of(LuminaireShape::kEllipse, l.world_from_light, l.size_x, l.size_y), exact * kPi / 4,
                1e-9 * exact + 1e-12);
  }
  const Affine mirrored{{-2, 0, 0}, {0, 3, 0}, {0, 0, 1}, {}};
  EXPECT_DOUBLE_EQ(area_of(LuminaireShape::kRectangle, mirrored, 1, 1), 6.0);
}

TEST(Luminaire, DarkWithoutPowerOrArea) {
  EXPECT_TRUE(Luminaire(light(LuminaireShape::kRectangle, {}, 0, 1), {}).dark());
  AreaLuminaire off = light(LuminaireShape::kEllipse, {}, 1, 1);
  EXPECT_FALSE(Luminaire(off, {}).dark());
  off.radiance = {0, 0, 0};
  EXPECT_TRUE(Luminaire(off, {}).dark());
}

}  // namespace
}  // namespace penumbra
