// SPDX-License-Identifier: GPL-3.0-or-later
// Point lights and spots. Oracle: the definition, area x cos cos' / (pi r^2) summed over small patches of the
// sphere or disk in double, which knows neither cones nor closed forms.
#include <gtest/gtest.h>

#include "luminaire/luminaire.h"
#include "oracles.h"

namespace penumbra {
namespace {

using test::kPi;
using test::surface_at;
using test::Trials;

PointLuminaire bulb(RoundShape shape, double radius, const Affine& transform = {}) {
  return {"bulb", shape, transform, radius, {1, 1, 1}, true, {}};
}

/// What leaves a patch towards `direction`, unit: the spot's factor.
double spot_factor(const PointLuminaire& light, const Vec3d& direction) {
  if (!light.spot) return 1;
  const double cosine = -normalize(light.world_from_light.inverse_vector(direction)).z;
  const double c = std::cos(light.spot->angle / 2), width = (1 - c) * light.spot->blend;
  const double x = width > 0 ? std::clamp((cosine - c) / width, 0.0, 1.0) : cosine > c;
  return x * x * (3 - 2 * x) * (light.spot->cosine_falloff ? std::max(cosine, 0.0) : 1.0);
}

double patch(const PointLuminaire& light, const Vec3d& to_light, const Vec3d& facing, double area,
             const Vec3d& normal) {
  const double r2 = dot(to_light, to_light), r = std::sqrt(r2);
  const double above = dot(to_light, normal) / r, front = -dot(to_light, facing) / r;
  if (above <= 0 || front <= 0) return 0;
  return area * above * front / (kPi * r2) * spot_factor(light, -to_light / r);
}

/// E / pi at a point for unit intensity, by n x n patches.
double brute_force(const PointLuminaire& light, const Vec3d& point, const Vec3d& normal, int n) {
  const Vec3d centre = light.world_from_light.origin;
  const Vec3d z = normalize(point - centre), x = normalize(cross(z, {0.31, 0.52, 0.17})), y = cross(z, x);
  double sum = 0;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const double phi = 2 * kPi * (j + 0.5) / n, s = (i + 0.5) / n;
      if (light.shape == RoundShape::kSphere) {
        const double c = 2 * s - 1, sine = std::sqrt(1 - c * c);
        const Vec3d out = x * (sine * std::cos(phi)) + y * (sine * std::sin(phi)) + z * c;
        sum += patch(light, centre + out * light.radius - point, out,
                     4 * kPi * light.radius * light.radius / (double(n) * n), normal);
      } else {
        const double rho = light.radius * std::sqrt(s);
        sum += patch(light, centre + x * (rho * std::cos(phi)) + y * (rho * std::sin(phi)) - point, z,
                     kPi * light.radius * light.radius / (double(n) * n), normal);
      }
    }
  return sum / (kPi * light.radius * light.radius);
}

double sampled(const Luminaire& luminaire, const SurfacePoint& surface, uint32_t side) {
  struct Adapter final : Emitter {
    const Luminaire& l;
    explicit Adapter(const Luminaire& luminaire) : l(luminaire) {}
    double form_factor(const SurfacePoint&) const override { return 0; }
    void evaluate(const SurfacePoint& s, const float* u, const float* v, uint32_t n,
                  LightPoints& out) const override {
      l.evaluate(s, u, v, n, out);
    }
  } adapter(luminaire);
  return midpoint_form_factor(adapter, surface, side);
}

class Round : public testing::TestWithParam<RoundShape> {};
INSTANTIATE_TEST_SUITE_P(Shapes, Round, testing::Values(RoundShape::kSphere, RoundShape::kFacingDisk));

TEST_P(Round, FormFactorIsTheIntegralHorizonIncluded) {
  // 400 x 400 patches: up to 2e-3 where the sphere's own limb or the horizon cuts patches.
  Trials trials(11);
  int cut = 0, unseen = 0;
  for (int trial = 0; trial < 120; ++trial) {
    Affine t = trials.rigid(1);
    const PointLuminaire light = bulb(GetParam(), trials.uniform(0.05, 0.9), t);
    const Vec3d point = t.origin + trials.direction() * trials.uniform(1, 3), n = trials.direction();
    const Luminaire luminaire(light, {});
    const double exact = brute_force(light, point, n, 400), f = luminaire.form_factor(surface_at(point, n));
    EXPECT_NEAR(f, exact, 3e-3 * exact + 2e-5) << "trial " << trial;
    EXPECT_EQ(luminaire.unseen_from(surface_at(point, n)), f == 0) << "trial " << trial;
    // The midpoint rule in (u, v), 128 x 128: kinks cost 2e-4.
    EXPECT_NEAR(sampled(luminaire, surface_at(point, n), 128), f, 2e-4 * f + 2e-5) << "trial " << trial;
    const double height = dot(t.origin - point, n);
    cut += f > 0 && std::abs(height) < light.radius;
    unseen += f == 0;
  }
  EXPECT_GT(cut, 10);
  EXPECT_GT(unseen, 10);
}

TEST_P(Round, SpotsAreTheIntegral) {
  // As above; a narrow blend is a step, which costs 400^-3/2 of the patches and 64^-3/2 = 2e-3 of the points.
  Trials trials(12);
  int fading = 0, dark = 0;
  for (int trial = 0; trial < 240; ++trial) {
    Affine t = trial % 3 ? trials.rigid(1) : trials.transform(1);
    PointLuminaire light = bulb(GetParam(), trials.uniform(0.05, 0.5), t);
    light.spot = SpotCone{trials.uniform(0.3, 3.1), trial % 4 ? trials.uniform(0, 1) : 0.0, trial % 2 == 0};
    const Vec3d point =
                    t.point(Vec3d{trials.uniform(-1, 1), trials.uniform(-1, 1), -2} * trials.uniform(0.8, 2)),
                n = normalize(normalize(t.origin - point) + trials.direction() * 0.7);
    if (length(point - t.origin) < 0.6) continue;
    const Luminaire luminaire(light, {});
    const double exact = brute_force(light, point, n, 400), f = luminaire.form_factor(surface_at(point, n));
    const double whole = brute_force(bulb(GetParam(), light.radius, t), point, n, 100);
    EXPECT_NEAR(f, exact, 2e-3 * whole) << "trial " << trial;
    EXPECT_NEAR(sampled(luminaire, surface_at(point, n), 64), exact, 4e-3 * whole) << "trial " << trial;
    fading += exact > 0.02 * whole && exact < 0.98 * whole;
    dark += exact == 0;
  }
  EXPECT_GT(fading, 40);
  EXPECT_GT(dark, 5);
}

TEST_P(Round, SmallRadiusIsThePoint) {
  // The limit of radius 0, relative (radius / distance)^2 = 1e-8.
  Trials trials(13);
  for (int trial = 0; trial < 100; ++trial) {
    const Affine t = trials.rigid(0);
    const Vec3d point = trials.direction() * 2.0, n = normalize(-point + trials.direction());
    PointLuminaire small = bulb(GetParam(), 2e-4, t), zero = bulb(GetParam(), 0, t);
    const Luminaire a(small, {}), b(zero, {});
    EXPECT_FALSE(a.is_point());
    EXPECT_TRUE(b.is_point());
    const double exact = -dot(point, n) / 2 / (kPi * 4);
    EXPECT_NEAR(b.form_factor(surface_at(point, n)), exact, 1e-14);
    EXPECT_NEAR(a.form_factor(surface_at(point, n)), exact, 2e-8 * exact);
    EXPECT_NEAR(sampled(b, surface_at(point, n), 8), exact, 1e-6 * exact);
  }
}

TEST(Round, PointsLieOnTheSphere) {
  // Float rounding near the limb: the square root of 1e-7.
  Trials trials(14);
  for (int trial = 0; trial < 50; ++trial) {
    const PointLuminaire light = bulb(RoundShape::kSphere, trials.uniform(0.01, 0.9), trials.rigid(1));
    const bool inside = trial % 5 == 0;
    const Vec3d centre = light.world_from_light.origin;
    const Vec3d point = centre + trials.direction() * (inside ? 0.5 * light.radius : trials.uniform(1, 3));
    const Luminaire luminaire(light, {});
    alignas(64) float u[kBatch], v[kBatch];
    for (uint32_t i = 0; i < kBatch; ++i) u[i] = float(i) / kBatch, v[i] = float(i * 37 % kBatch) / kBatch;
    LightPoints points;
    luminaire.evaluate(surface_at(point, normalize(centre - point)), u, v, kBatch, points);
    for (uint32_t i = 0; i < kBatch; ++i) {
      const Vec3d to_light{double(points.x[i]), double(points.y[i]), double(points.z[i])};
      EXPECT_NEAR(length(point + to_light - centre), light.radius, 1e-3 * light.radius + 1e-6);
      if (!inside) {
        EXPECT_LT(dot(point + to_light - centre, to_light), 1e-3);  // the near side
      }
    }
  }
}

TEST(Round, InsideASphereIsAFurnace) {
  const Luminaire luminaire(bulb(RoundShape::kSphere, 2), {});
  const SurfacePoint surface = surface_at({0.3, 1.1, -0.7}, normalize(Vec3d{1, 2, 3}));
  EXPECT_DOUBLE_EQ(luminaire.form_factor(surface), 1 / (kPi * 4));
  EXPECT_NEAR(sampled(luminaire, surface, 16), 1 / (kPi * 4), 1e-7);
}

TEST(Round, RenderSpaceDoesNotMatter) {
  // Centre and power-of-two scale: the product of form factor and radiance stays.
  const Affine t{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {3, 2, 5}};
  const SurfacePoint here = surface_at({3, 2, 1}, normalize(Vec3d{0.3, 0, 1}));
  const Normalization moved{{1, 2, 3}, 0.25};
  const SurfacePoint there = surface_at(moved.point(here.position), here.normal);
  for (double radius : {0.0, 0.5}) {
    PointLuminaire light = bulb(RoundShape::kSphere, radius, t);
    light.spot = SpotCone{1.5, 0.5, true};
    const Luminaire a(light, {}), b(light, moved);
    EXPECT_NEAR(b.form_factor(there) * b.radiance().x, a.form_factor(here) * a.radiance().x, 1e-12);
  }
}

}  // namespace
}  // namespace penumbra
