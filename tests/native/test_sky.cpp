// SPDX-License-Identifier: GPL-3.0-or-later
// The sky as a light. Oracle: the picture itself, looked up in many directions and summed with their cosines.
#include <gtest/gtest.h>

#include "luminaire/sky.h"
#include "oracles.h"

namespace penumbra {
namespace {

using test::kPi;
using test::surface_at;
using test::Trials;

std::shared_ptr<const Environment> environment(uint32_t width, uint32_t height, std::vector<Vec3f> pixels,
                                               const Affine& local_from_world = {}, bool smooth = false) {
  return std::make_shared<const Environment>(Environment{
      std::make_shared<const SkyPicture>(width, height, std::move(pixels)), local_from_world, smooth});
}

std::shared_ptr<const Environment> picture(uint32_t width, uint32_t height, uint32_t seed, bool grey) {
  Trials trials(seed);
  const Affine t = trials.rigid(0);
  std::vector<Vec3f> pixels;
  for (uint32_t i = 0; i < width * height; ++i) {
    const auto v = float(trials.uniform(0, 1) < 0.02 ? 200 : trials.uniform(0, 1));
    pixels.push_back(grey ? Vec3f(v, v * 0.5f, v * 0.25f) : Vec3f(v, float(trials.uniform(0, 1)), 1));
  }
  return environment(width, height, std::move(pixels), t);
}

Background background(std::shared_ptr<const Environment> sky) {
  return {{2, 1, 0.5}, false, std::move(sky), true, true};
}

/// E / pi of each channel, by n x 2n directions of equal solid angle.
Vec3d brute_force(const Background& b, const Vec3d& normal, int n) {
  Vec3d sum;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < 2 * n; ++j) {
      const double z = 2 * (i + 0.5) / n - 1, sine = std::sqrt(1 - z * z), phi = kPi * (j + 0.5) / n;
      const Vec3d d{sine * std::cos(phi), sine * std::sin(phi), z};
      if (dot(d, normal) > 0) sum += b.radiance(d) * dot(d, normal);
    }
  return sum * (4 * kPi / (2.0 * n * n) / kPi);
}

/// E / pi by closed form and by points of (u, v).
std::pair<Vec3d, Vec3d> from_luminaires(const std::vector<Luminaire>& parts, const SurfacePoint& surface) {
  Vec3d exact, points_sum;
  for (const Luminaire& part : parts) {
    exact += part.radiance() * part.form_factor(surface);
    LightPoints points;
    alignas(64) float u[kBatch], v[kBatch];
    double sum = 0;
    for (uint32_t row = 0; row < 256; ++row)
      for (uint32_t first = 0; first < 256; first += kBatch) {
        for (uint32_t i = 0; i < kBatch; ++i) {
          u[i] = (float(first + i) + 0.5f) / 256;
          v[i] = (float(row) + 0.5f) / 256;
        }
        part.evaluate(surface, u, v, kBatch, points);
        for (float f : points.form_factor) sum += double(f) / 65536;
      }
    points_sum += part.radiance() * sum;
  }
  return {exact, points_sum};
}

class Sky : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Hues, Sky, testing::Values(true, false));

TEST_P(Sky, PicturesSendWhatTheyShow) {
  // 700 x 1400 directions over 32 x 16 pixels: 3e-3 (edges of bright pixels). 256 x 256 points, which jump
  // from one bright pixel to the next: 1e-2.
  Trials trials(31);
  const Background b = background(picture(32, 16, 32, GetParam()));
  const auto parts = sky_luminaires(b);
  EXPECT_EQ(parts.size(), GetParam() ? 1u : 3u);
  for (int trial = 0; trial < 12; ++trial) {
    const Vec3d n = trials.direction();
    const auto [exact, points] = from_luminaires(parts, surface_at({}, n));
    const Vec3d expected = brute_force(b, n, 700);
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(exact[c], expected[c], 3e-3 * expected[c]) << "trial " << trial;
      EXPECT_NEAR(points[c], expected[c], 1e-2 * expected[c]) << "trial " << trial;
    }
  }
}

TEST_P(Sky, PointsLieInThePicturesBrightPixels) {
  // One pixel of the sky shines: every point must be seen there.
  std::vector<Vec3f> pixels(16 * 8);
  pixels[5 * 16 + 3] = GetParam() ? Vec3f(1, 1, 1) : Vec3f(0, 1, 0);
  const Background b = background(environment(16, 8, pixels, Trials(33).rigid(0)));
  const auto parts = sky_luminaires(b);
  ASSERT_EQ(parts.size(), 1u);
  Trials trials(34);
  LightPoints points;
  for (uint32_t i = 0; i < kBatch; ++i) {
    const float u = float(trials.uniform(0.01, 0.99)), v = float(trials.uniform(0.01, 0.99));
    parts[0].evaluate(surface_at({}, {0, 0, 1}), &u, &v, 1, points);
    EXPECT_GT(max_component(b.radiance({double(points.x[0]), double(points.y[0]), double(points.z[0])})), 0);
  }
}

TEST(Sky, ConstantIsAFurnace) {
  const auto parts = sky_luminaires({{3, 2, 1}, false, {}, true, true});
  ASSERT_EQ(parts.size(), 1u);
  const auto [exact, points] = from_luminaires(parts, surface_at({}, normalize(Vec3d{1, 2, -3})));
  EXPECT_EQ(exact, (Vec3d{3, 2, 1}));
  EXPECT_EQ(points, (Vec3d{3, 2, 1}));
}

TEST(Sky, OffOrBlackIsNoLuminaire) {
  EXPECT_TRUE(sky_luminaires({{3, 2, 1}}).empty());
  EXPECT_TRUE(sky_luminaires({{0, 0, 0}, false, {}, true})[0].dark());
  EXPECT_TRUE(sky_luminaires(background(environment(4, 2, std::vector<Vec3f>(8)))).empty());
}

TEST(Sky, LargePicturesAreAveragedDown) {
  // 5000 x 3 pixels become 1666 x 3 or so: a smooth picture sends the same, 1e-3.
  std::vector<Vec3f> pixels;
  for (uint32_t i = 0; i < 20000; ++i) {
    const auto v = float(2 + std::sin(2 * kPi * double(i % 5000) / 5000));
    pixels.push_back({v, v, v});
  }
  const Background b = background(environment(5000, 4, pixels, {}, true));
  const Vec3d n = normalize(Vec3d{0.3, -0.5, 0.2});
  const auto [exact, points] = from_luminaires(sky_luminaires(b), surface_at({}, n));
  EXPECT_NEAR(exact.x, brute_force(b, n, 500).x, 2e-3 * exact.x);
  EXPECT_NEAR(points.x, exact.x, 2e-3 * exact.x);
}

}  // namespace
}  // namespace penumbra
