// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include "small_scene.h"
#include "visibility/shadow_rays.h"

namespace penumbra {
namespace {

/// A floor under a smaller roof: some rays from the floor pass it.
Geometry floor_and_roof() {
  return test::place(
      {test::quad({-4, -4, 0}, {8, 0, 0}, {0, 8, 0}), test::quad({-1, -1, 1}, {2, 0, 0}, {0, 2, 0})});
}

/// Whatever shares packets, each ray finds what it finds among those of its surface point alone.
TEST(ShadowRays, FromManySurfacesFindWhatThoseFromOneDo) {
  const Geometry geometry = floor_and_roof();
  for (uint32_t points : {1u, kMostPoints})
    for (uint32_t count : {1u, 7u, kPacket}) {
      SurfaceColumns columns;
      std::vector<SurfacePoint> surfaces(count);
      uint32_t group[kPacket];
      std::vector<float> x, y, z, contribution;
      for (uint32_t i = 0; i < count; ++i) {
        const Vec3d above{-2 + 0.27 * i, 0.1 * i - 0.8, 0.5};
        ASSERT_TRUE(test::first_surface(geometry, above, {0, 0, -1}, surfaces[i]));
        columns.add(surfaces[i]);
        group[i] = i < 3 ? 0 : i < 9 ? 1 : i;
      }
      const float scale = float(geometry.normalization().scale);
      for (uint32_t k = 0; k < points; ++k)
        for (uint32_t i = 0; i < count; ++i) {
          x.push_back(scale * (0.9f * float(k) - 1)), y.push_back(scale * 0.3f * float(i % 5)),
              z.push_back(scale * 2);
          contribution.push_back((i + k) % 6 == 5 ? 0.0f : 1.0f + float(i));
        }
      std::vector<float> each = contribution;
      const uint32_t traced =
          hide_from_each(geometry, columns, group, {}, points, x.data(), y.data(), z.data(), each.data());
      uint32_t expected = 0, hidden = 0;
      for (uint32_t i = 0; i < count; ++i) {
        alignas(64) float own[4][kPacket] = {};
        alignas(64) int rays[kPacket];
        for (uint32_t k = 0; k < points; ++k) {
          const uint32_t at = k * count + i;
          own[0][k] = x[at], own[1][k] = y[at], own[2][k] = z[at], own[3][k] = contribution[at];
        }
        expected += ShadowRays(geometry, surfaces[i]).hide(kPacket, own[0], own[1], own[2], own[3], rays);
        for (uint32_t k = 0; k < points; ++k) {
          EXPECT_EQ(each[k * count + i], own[3][k]) << "ray " << k << " of surface " << i;
          hidden += contribution[k * count + i] > 0 && own[3][k] == 0;
        }
      }
      EXPECT_EQ(traced, expected);
      if (count == kPacket) {
        EXPECT_GT(hidden, 0u);
        EXPECT_LT(hidden, traced);
      }
    }
}

/// Many points of one surface: what each finds does not depend on how many packets are asked for at once.
TEST(ShadowRays, ManyPacketsFindWhatEachFinds) {
  const Geometry geometry = floor_and_roof();
  SurfacePoint surface;
  ASSERT_TRUE(test::first_surface(geometry, {-0.6, 0.1, 0.5}, {0, 0, -1}, surface));
  const float scale = float(geometry.normalization().scale);
  alignas(64) float x[kBatch], y[kBatch], z[kBatch], together[kBatch], apart[kBatch];
  alignas(64) int rays_together[kBatch], rays_apart[kBatch];
  for (uint32_t i = 0; i < kBatch; ++i) {
    x[i] = scale * 0.4f * float(i % 16), y[i] = scale * 0.2f * float(i / 16), z[i] = scale * 2;
    // The second packet has no ray at all.
    together[i] = apart[i] = i % 5 == 3 || i / kPacket == 1 ? 0.0f : 1.0f + float(i);
  }
  const ShadowRays rays(geometry, surface);
  const uint32_t traced = rays.hide(kBatch, x, y, z, together, rays_together);
  uint32_t expected = 0, hidden = 0;
  for (uint32_t k = 0; k < kBatch; k += kPacket)
    expected += rays.hide(kPacket, x + k, y + k, z + k, apart + k, rays_apart + k);
  for (uint32_t i = 0; i < kBatch; ++i) {
    EXPECT_EQ(together[i], apart[i]) << "point " << i;
    EXPECT_EQ(rays_together[i], rays_apart[i]) << "point " << i;
    hidden += rays_together[i] && together[i] == 0;
  }
  EXPECT_EQ(traced, expected);
  EXPECT_GT(hidden, 0u);
  EXPECT_LT(hidden, traced);
}

}  // namespace
}  // namespace penumbra
