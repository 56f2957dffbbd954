// SPDX-License-Identifier: GPL-3.0-or-later
// The sun. Oracle: radiance x cosine summed over small solid angles of the disk of directions, in double.
#include <gtest/gtest.h>

#include "luminaire/luminaire.h"
#include "oracles.h"

namespace penumbra {
namespace {

using test::kPi;
using test::surface_at;
using test::Trials;

SunLuminaire sun(const Vec3d& to_sun, double half_angle) {
  return {"sun", to_sun, half_angle, {1, 1, 1}, true};
}

/// E of a surface for irradiance 1 of one that faces the sun.
double brute_force(const SunLuminaire& s, const Vec3d& normal, int n) {
  const Vec3d z = normalize(s.to_sun), x = normalize(cross(z, {0.31, 0.52, 0.17})), y = cross(z, x);
  const double least = std::cos(s.half_angle);
  double here = 0, facing = 0;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const double c = least + (1 - least) * (i + 0.5) / n, sine = std::sqrt(1 - c * c);
      const double phi = 2 * kPi * (j + 0.5) / n;
      here += std::max(dot(x * (sine * std::cos(phi)) + y * (sine * std::sin(phi)) + z * c, normal), 0.0);
      facing += c;
    }
  return here / facing;
}

TEST(Sun, FormFactorIsTheIntegralHorizonIncluded) {
  // 300 x 300 directions: 2e-4 where the horizon cuts; 2048 points of (u, v): 1e-3.
  Trials trials(21);
  int cut = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const Vec3d n = trials.direction();
    const SunLuminaire description = sun(trials.direction() * 3.0, trials.uniform(0.001, kPi / 2));
    const Luminaire luminaire(description, {{5, 6, 7}, 0.01});
    const double exact = brute_force(description, n, 300);
    const double f = luminaire.form_factor(surface_at({}, n)) * luminaire.radiance().x * kPi;
    EXPECT_NEAR(f, exact, 2e-4 * exact + 1e-5) << "trial " << trial;
    LightPoints points;
    alignas(64) float u[kBatch], v[kBatch];
    double sum = 0;
    for (int batch = 0; batch < 32; ++batch) {
      for (uint32_t i = 0; i < kBatch; ++i) {
        u[i] = (float(i) + 0.5f) / kBatch;
        v[i] = (float(batch) + 0.5f) / 32;
      }
      luminaire.evaluate(surface_at({}, n), u, v, kBatch, points);
      for (uint32_t i = 0; i < kBatch; ++i) {
        sum += double(points.form_factor[i]) / (32 * kBatch);
        // Beyond the scene, which has a diagonal of at most 2 sqrt(3).
        EXPECT_GT(length(Vec3d{double(points.x[i]), double(points.y[i]), double(points.z[i])}), 3.5);
      }
    }
    EXPECT_NEAR(sum, f, 1e-3) << "trial " << trial;
    EXPECT_EQ(luminaire.unseen_from(surface_at({}, n)), f == 0);
    cut += exact > 0 && std::abs(dot(normalize(description.to_sun), n)) < std::sin(description.half_angle);
  }
  EXPECT_GT(cut, 50);
}

TEST(Sun, OfNoAngleIsOneDirection) {
  const Vec3d n = normalize(Vec3d{0.2, 0.1, 1});
  const Luminaire point(sun({0, 0, 2}, 0), {}), small(sun({0, 0, 2}, 1e-4), {});
  EXPECT_TRUE(point.is_point());
  EXPECT_FALSE(small.is_point());
  EXPECT_DOUBLE_EQ(point.form_factor(surface_at({}, n)), n.z);
  EXPECT_NEAR(small.form_factor(surface_at({}, n)), n.z, 1e-14);
  EXPECT_TRUE(point.unseen_from(surface_at({}, -n)));
}

}  // namespace
}  // namespace penumbra
