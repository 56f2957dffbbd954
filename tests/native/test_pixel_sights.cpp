// SPDX-License-Identifier: GPL-3.0-or-later
// Surfaces in an edge pixel. Oracles: a cube's sides; shares counted by hand; a simulation of many pixels.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "render/pixel_sights.h"
#include "sampling/hash.h"

namespace penumbra {
namespace {

Mesh cube() {
  Mesh mesh;
  mesh.name = "cube";
  for (int i = 0; i < 8; ++i)
    mesh.positions.push_back({i & 1 ? 1. : -1., i & 2 ? 1. : -1., i & 4 ? 1. : -1.});
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  mesh.material_slots = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1};
  return mesh;
}

Primitive triangle(uint32_t instance, uint32_t number) {
  Primitive primitive;
  primitive.instance = instance;
  primitive.triangle = number;
  return primitive;
}

TEST(PixelSights, TellsSidesMaterialsAndObjectsApart) {
  const Geometry geometry({cube()}, {{"one", 0, {}, {0, 1}}, {"two", 0, {}, {0, 1}}});
  PixelSights sights;
  uint32_t index = 0;
  const auto number = [&](const Primitive& met) {
    const uint32_t k = sights.surface_of(geometry, met);
    sights.count_ray(k, index++);
    return k;
  };
  EXPECT_EQ(number(triangle(0, 0)), 0u);
  EXPECT_EQ(number(triangle(0, 1)), 0u) << "the other half of a side";
  EXPECT_EQ(number(triangle(0, 2)), 1u) << "the opposite side";
  EXPECT_EQ(number(triangle(0, 10)), 2u);
  EXPECT_EQ(number(triangle(0, 11)), 3u) << "of another material";
  EXPECT_EQ(number(triangle(1, 0)), 4u) << "of another object";
  EXPECT_EQ(number({}), 5u) << "nothing";
  EXPECT_EQ(number(triangle(1, 4)), 5u) << "beyond what is told apart, the last stands for all";
  EXPECT_EQ(number(triangle(0, 3)), 1u) << "those that are known stay known";
  EXPECT_EQ(sights.rays(), 9u);
  EXPECT_EQ(sights.surfaces()[0].rays.now, 2u);
  EXPECT_EQ(sights.surfaces()[5].indices[0], 6u);
}

TEST(PixelSights, ACurvedSurfaceIsOneSurface) {
  Mesh arc;
  arc.name = "arc";
  constexpr uint32_t kSteps = 12;  // of 5 degrees
  for (uint32_t i = 0; i <= kSteps; ++i)
    for (int side = 0; side < 2; ++side)
      arc.positions.push_back({std::cos(0.0873 * i), std::sin(0.0873 * i), double(side)});
  for (uint32_t i = 0; i < kSteps; ++i) {
    arc.triangles.push_back({2 * i, 2 * i + 1, 2 * i + 3});
    arc.triangles.push_back({2 * i, 2 * i + 3, 2 * i + 2});
  }
  const Geometry geometry({arc}, {{"arc", 0, {}, {0}}});
  const Facet first = geometry.facet_of(triangle(0, 0));
  EXPECT_TRUE(same_surface(first, geometry.facet_of(triangle(0, 5)))) << "10 degrees further";
  EXPECT_FALSE(same_surface(first, geometry.facet_of(triangle(0, 22)))) << "55 degrees further";
}

TEST(PixelSights, FlatFacetsTellTheAngleBetweenThem) {
  Mesh roof;
  roof.name = "roof";
  roof.positions = {{-1, 0, 0}, {0, 0, 0.1}, {0, 1, 0.1}, {1, 0, 0}};
  roof.triangles = {{0, 1, 2}, {1, 3, 2}};
  const Geometry flat({roof}, {{"roof", 0, {}, {0}}});
  // Both sides rise 0.1 over 1 towards the ridge: twice atan(0.1).
  EXPECT_NEAR(step_between(flat.facet_of(triangle(0, 0)), flat.facet_of(triangle(0, 1))),
              std::sin(2 * std::atan(0.1)), 1e-6);
  roof.corner_normals.assign(6, {0, 0, 1});
  const Geometry smooth({roof}, {{"roof", 0, {}, {0}}});
  EXPECT_EQ(step_between(smooth.facet_of(triangle(0, 0)), smooth.facet_of(triangle(0, 1))), 0);

  PixelSights sights;
  sights.surface_of(flat, triangle(0, 0));
  EXPECT_EQ(sights.surfaces()[0].step, 0);
  EXPECT_EQ(sights.surface_of(flat, triangle(0, 1)), 0u) << "one surface";
  EXPECT_NEAR(sights.surfaces()[0].step, std::sin(2 * std::atan(0.1)), 1e-6);
  EXPECT_EQ(sights.surfaces()[0].wanted_values(false), 1u) << "flat";
  sights.surfaces()[0].rays.now = 16;
  EXPECT_EQ(sights.surfaces()[0].wanted_values(true), kMostProbes) << "in penumbra";
}

/// A pixel of an edge: the first half of `shares` sees a surface of value 1, of n rays; `samples` of them are
/// whole.
struct EdgePixel {
  EdgePixel(uint32_t samples, uint32_t rays, const std::function<bool(uint32_t)>& sees_white) {
    const Geometry geometry({cube()}, {{"white", 0, {}, {0, 1}}, {"black", 0, {}, {0, 1}}});
    for (uint32_t i = 0; i < rays; ++i) {
      const bool white = sees_white(i);
      const uint32_t k = sights.surface_of(geometry, triangle(white ? 0 : 1, 0));
      sights.count_ray(k, i);
      if (2 * (i + 1) == rays) sights.mark_rays();
      if (i >= samples) continue;
      SeenSurface& surface = sights[k];
      ++surface.samples.now;
      ++surface.valued;
      surface.value += white ? Vec3d{1, 1, 1} : Vec3d{};
      surface.alpha += 1;
      surface.x += white, surface.xx += white;
      mean += white / double(samples);
    }
  }
  PixelSights sights;
  double mean = 0;
};

TEST(PixelSights, RaysCorrectTheShares) {
  // Of 8 samples half see white, of 16 rays three quarters.
  const EdgePixel pixel(8, 16, [](uint32_t i) { return i >= 8 || i % 2 == 0; });
  EXPECT_DOUBLE_EQ(pixel.mean + pixel.sights.correction(8).value.x, 0.75);
  EXPECT_DOUBLE_EQ(pixel.sights.correction(8).alpha, 0) << "both are opaque";
  EXPECT_DOUBLE_EQ(pixel.sights.spread_within(), 0);
  EXPECT_DOUBLE_EQ(pixel.sights.spread_between(1), 0.75 * 0.25);
  EXPECT_DOUBLE_EQ(pixel.sights.mean_variance(8, -1), 0);
}

TEST(PixelSights, WithoutSamplesSharesWeighValues) {
  // Three quarters of 16 rays see white; both surfaces' values are known from single places.
  EdgePixel pixel(2, 16, [](uint32_t i) { return i % 4 != 1; });
  EXPECT_DOUBLE_EQ(pixel.sights.correction(0).value.x, 0.75);
  EXPECT_DOUBLE_EQ(pixel.sights.correction(0).alpha, 1);
  // A slope of 0.1 a pixel: half a pixel times the share that a surface does not fill, each by one value.
  const double white = 0.75 * 0.25 * 0.5 * 0.1, black = 0.25 * 0.75 * 0.5 * 0.1;
  EXPECT_NEAR(pixel.sights.mean_variance(0, 0.1), white * white + black * black, 1e-12);
}

TEST(PixelSights, BlocksTellTheVarianceOfIndependentRays) {
  // Rays that see white with probability 0.3, independent of each other: blocks of infinitely many
  // dimensions.
  constexpr uint32_t kRays = 32;
  double mean = 0, squares = 0, told = 0;
  constexpr int kPixels = 4000;
  for (int p = 0; p < kPixels; ++p) {
    EdgePixel pixel(kRays, kRays, [p](uint32_t i) {
      return double(hash_of(uint64_t(p) * kRays + i) >> 11) * 0x1p-53 < 0.3;
    });
    mean += pixel.mean / kPixels;
    squares += pixel.mean * pixel.mean / kPixels;
    told += pixel.sights.close_rays(1, 1e9) / kPixels;
  }
  const double variance = squares - mean * mean;
  EXPECT_NEAR(variance, 0.21 / kRays, 0.1 * 0.21 / kRays);
  // One degree of freedom: the mean of 4000 has a standard error of 2.2 %.
  EXPECT_NEAR(told, 0.21 / kRays, 0.09 * 0.21 / kRays);
}

}  // namespace
}  // namespace penumbra
