// SPDX-License-Identifier: GPL-3.0-or-later
// The Phong lobe integrated over the hemisphere, and its reciprocity. The integrals use the midpoint rule in
// theta and phi, 1000 x 1000: with exponent 200 the lobe is 0.07 rad wide, which leaves (h / 0.07)^2 / 24 =
// 2e-5, and the float cosine's rounding adds 200 x 2^-24; 1e-4 is safe.
#include <gtest/gtest.h>

#include <vector>

#include "material/shading_point.h"
#include "oracles.h"

namespace penumbra {
namespace {

using test::kPi;
using test::Trials;

SurfacePoint surface_with(const Vec3d& normal) {
  return {{}, normal, normal, 0, 0, 0, {}};
}

Closures phong_of(double exponent) {
  Closures m;
  m.phong = {0.5, 0.5, 0.5};
  m.phong_exponent = exponent;
  return m;
}

/// BRDF x pi / albedo for one pair of directions: evaluate_glossy with a form factor of 1.
double lobe(const SurfacePoint& surface, const Closures& material, const Vec3d& ray, const Vec3d& to_light) {
  const float x = float(to_light.x), y = float(to_light.y), z = float(to_light.z), one = 1;
  float out = -1;
  evaluate_glossy(ShadingPoint(surface, material, ray), &x, &y, &z, &one, 1, &out);
  return out;
}

/// Integral of BRDF / albedo x cos over the hemisphere around +z, the viewer at angle `theta` from it. The
/// form factor of a patch of solid angle w in direction d is cos w / pi.
double reflectance(double exponent, double theta) {
  constexpr int kSteps = 1000;
  const SurfacePoint surface = surface_with({0, 0, 1});
  const Closures material = phong_of(exponent);
  const ShadingPoint point(surface, material, {-std::sin(theta), 0, -std::cos(theta)});
  std::vector<float> x(kSteps), y(kSteps), z(kSteps), form_factor(kSteps), out(kSteps);
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double angle = (i + 0.5) / kSteps * kPi / 2, cosine = std::cos(angle), sine = std::sin(angle);
    const double patch = sine * (kPi / 2 / kSteps) * (2 * kPi / kSteps);  // solid angle
    for (int k = 0; k < kSteps; ++k) {
      const double phi = 2 * kPi * (k + 0.5) / kSteps;
      // Any length: directions reach to the luminaire.
      x[k] = float(3 * sine * std::cos(phi)), y[k] = float(3 * sine * std::sin(phi)),
      z[k] = float(3 * cosine);
      form_factor[k] = float(cosine * patch / kPi);
    }
    evaluate_glossy(point, x.data(), y.data(), z.data(), form_factor.data(), kSteps, out.data());
    for (float v : out) sum += double(v);
  }
  return sum;
}

TEST(Phong, ReflectsItsAlbedoAtNormalIncidenceAndNoMoreElsewhere) {
  for (double exponent : {0.0, 1.0, 7.5, 50.0, 200.0}) {
    EXPECT_NEAR(reflectance(exponent, 0), 1, 1e-4) << "exponent " << exponent;
    double before = 1 + 1e-4;
    for (double theta : {0.3, 0.8, 1.2, 1.5}) {
      const double r = reflectance(exponent, theta);
      EXPECT_GT(r, 0);
      EXPECT_LE(r, before + 1e-4) << "exponent " << exponent << ", angle " << theta;
      before = r;
    }
  }
}

TEST(Phong, ExponentZeroAtNormalIncidenceIsDiffuse) {
  // cos^0 = 1 wherever the mirror direction's hemisphere reaches: the same BRDF as a diffuse one, 1 / pi.
  const SurfacePoint surface = surface_with({0, 0, 1});
  Trials trials(1);
  for (int i = 0; i < 100; ++i) {
    Vec3d d = trials.direction();
    d.z = std::abs(d.z) + 0.01;
    EXPECT_FLOAT_EQ(float(lobe(surface, phong_of(0), {0, 0, -1}, d)), 1.0f);
  }
}

TEST(Phong, IsReciprocal) {
  // Viewer and light change places: the same value. Relative tolerance 1e-4: cos^50 of a float cosine.
  Trials trials(2);
  int compared = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vec3d n = trials.direction();
    Vec3d a = trials.direction(), b = trials.direction();
    if (dot(a, n) < 0) a = -a;
    if (dot(b, n) < 0) b = -b;
    const SurfacePoint surface = surface_with(n);
    for (double exponent : {1.0, 10.0, 50.0}) {
      const double there = lobe(surface, phong_of(exponent), -a, b),
                   back = lobe(surface, phong_of(exponent), -b, a);
      EXPECT_NEAR(there, back, 1e-4 * there + 1e-6);
      compared += there > 1e-3;
    }
  }
  EXPECT_GT(compared, 500);
}

TEST(Phong, ReflectsAtTheInterpolatedNormal) {
  // The facet lies flat, its smooth normal leans by 0.2 rad: a ray from above leaves at 0.4.
  const SurfacePoint surface{{}, {0, 0, 1}, {std::sin(0.2), 0, std::cos(0.2)}, 0, 0, 0, {}};
  const Closures material = phong_of(10);
  const Vec3d mirror = ShadingPoint(surface, material, {0, 0, -3}).mirror_direction;
  EXPECT_LE(max_abs(mirror - Vec3d{std::sin(0.4), 0, std::cos(0.4)}), 1e-15);
}

TEST(Phong, IsZeroWhereTheFormFactorIsAndBehindTheLobe) {
  const SurfacePoint surface = surface_with({0, 0, 1});
  const Closures material = phong_of(10);
  const ShadingPoint point(surface, material, {-1, 0, -1e-3});
  const float x[2] = {1, -1}, y[2] = {0, 0}, z[2] = {0.5f, 0.1f}, form_factor[2] = {1, 0};
  float out[2] = {-1, -1};
  evaluate_glossy(point, x, y, z, form_factor, 2, out);
  EXPECT_EQ(out[0], 0.0f);  // away from the mirror direction (-1, 0, 1e-3)
  EXPECT_EQ(out[1], 0.0f);  // in it, but without a form factor
}

}  // namespace
}  // namespace penumbra
