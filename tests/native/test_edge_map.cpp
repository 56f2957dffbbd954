// SPDX-License-Identifier: GPL-3.0-or-later
// Which pixels may show edges. Oracle: camera rays on a grid over each pixel's filter; where they meet more
// than one surface, the pixel must be marked.
#include <gtest/gtest.h>

#include <cmath>

#include "oracles.h"
#include "render/edge_map.h"
#include "small_scene.h"

namespace penumbra {
namespace {

using test::quad;

constexpr uint32_t kWidth = 48, kHeight = 36;

Mesh ball(uint32_t rings, bool smooth) {
  Mesh mesh;
  mesh.name = "ball";
  const uint32_t sides = 2 * rings;
  for (uint32_t r = 0; r <= rings; ++r)
    for (uint32_t s = 0; s < sides; ++s) {
      const double up = test::kPi * r / rings, round = test::kPi * s / rings;
      mesh.positions.push_back(
          {std::sin(up) * std::cos(round), std::sin(up) * std::sin(round), std::cos(up)});
      if (smooth) mesh.corner_normals.push_back(Vec3f(mesh.positions.back()));
    }
  mesh.normals_of_vertices = smooth;
  for (uint32_t r = 0; r < rings; ++r)
    for (uint32_t s = 0; s < sides; ++s) {
      const uint32_t a = r * sides + s, b = r * sides + (s + 1) % sides;
      if (r > 0) mesh.triangles.push_back({a, a + sides, b});
      if (r + 1 < rings) mesh.triangles.push_back({b, a + sides, b + sides});
    }
  return mesh;
}

Affine at(const Vec3d& place, double size) {
  return {{size, 0, 0}, {0, size, 0}, {0, 0, size}, place};
}

/// A floor of two colours under a smooth ball, one of facets that is placed twice, and a wire far thinner
/// than a pixel. None touches another.
Geometry shapes() {
  Mesh floor;
  floor.name = "floor";
  floor.positions = {{-9, -9, 0}, {0, -9, 0}, {9, -9, 0}, {-9, 9, 0}, {0, 9, 0}, {9, 9, 0}};
  floor.triangles = {{0, 1, 4}, {0, 4, 3}, {1, 2, 5}, {1, 5, 4}};
  floor.material_slots = {0, 0, 1, 1};
  std::vector<Mesh> meshes{floor, ball(9, true), ball(4, false),
                           quad({-4, -2, 0.5}, {8, 1.3, 0.4}, {0, 0.004, 0.001})};
  return Geometry(std::move(meshes), {{"floor", 0, {}, {0, 1}},
                                      {"smooth", 1, at({-1.5, 0.5, 1.3}, 1.2), {0}},
                                      {"facets", 2, at({1.5, 1.5, 1}, 0.8), {0}},
                                      {"facets too", 2, at({2.5, -1.2, 1}, 0.6), {0}},
                                      {"wire", 3, {}, {0}}});
}

Camera camera(CameraKind kind) {
  const Vec3d eye{1, -9, 7}, back = normalize(eye - Vec3d{0, 0, 0.5}),
                             right = normalize(cross({0, 0, 1}, back));
  Camera c{.kind = kind, .world_from_camera = {right, cross(back, right), back, eye}};
  const double half = kind == CameraKind::kPerspective ? 0.5 : 5;
  c.window = {-half, half, -0.75 * half, 0.75 * half};
  return c;
}

RenderSettings settings() {
  RenderSettings s;
  s.width = kWidth, s.height = kHeight, s.pixel_samples = 16;
  return s.validated();
}

/// A bit of each surface that a pixel shows within `reach` of its centre; those of one surface all alike.
bool shows_an_edge(const Geometry& geometry, const CameraRays& rays, uint32_t x, uint32_t y, double reach) {
  constexpr int kGrid = 9;
  Facet first;
  for (int i = 0; i < kGrid * kGrid; ++i) {
    const double dx = (i % kGrid * 2.0 / (kGrid - 1) - 1) * reach,
                 dy = (i / kGrid * 2.0 / (kGrid - 1) - 1) * reach;
    const Ray ray = rays.through(x + 0.5 + dx, y + 0.5 + dy);
    Hit hit;
    geometry.intersect(&ray, 1, &hit);
    const Facet facet = geometry.facet_of(hit);
    if (i == 0) first = facet;
    const bool same = hit.found() == (first.primitive.instance != Hit::kNone) &&
                      (!hit.found() || (facet.primitive.instance == first.primitive.instance &&
                                        facet.material == first.material &&
                                        (!facet.flat || step_between(facet, first) < 1e-3)));
    if (!same) return true;
  }
  return false;
}

TEST(EdgeMap, MarksEveryPixelThatShowsAnEdge) {
  const Geometry geometry = shapes();
  const RenderSettings s = settings();
  const PixelFilter filter(s.filter_type, s.filter_width);
  for (CameraKind kind : {CameraKind::kPerspective, CameraKind::kOrthographic}) {
    const CameraRays rays(camera(kind), geometry.normalization(), kWidth, kHeight);
    const auto map = make_edge_map(geometry, rays, {}, filter, s);
    ASSERT_TRUE(map);
    const double reach = filter.reach_of(0.1 * s.error_tolerance);
    int edges = 0, marked = 0, needless = 0;
    for (uint32_t y = 0; y < kHeight; ++y)
      for (uint32_t x = 0; x < kWidth; ++x) {
        const bool edge = shows_an_edge(geometry, rays, x, y, reach);
        edges += edge;
        marked += map->may_show_edge(x, y);
        needless += !edge && map->may_show_edge(x, y);
        if (edge) {
          EXPECT_TRUE(map->may_show_edge(x, y)) << x << ", " << y;
        }
      }
    // Hidden edges are marked, and the wire between two of the oracle's rays.
    EXPECT_GT(edges, 200);
    EXPECT_LT(needless, marked / 3);
    EXPECT_LT(marked, int(kWidth * kHeight) / 2);
  }
}

TEST(EdgeMap, MarksWiresThatNoRayMeets) {
  // Its places along the line at steps of a tenth of a pixel, without any ray.
  const Geometry geometry = shapes();
  const RenderSettings s = settings();
  const CameraRays rays(camera(CameraKind::kPerspective), geometry.normalization(), kWidth, kHeight);
  const auto map = make_edge_map(geometry, rays, {}, PixelFilter(s.filter_type, s.filter_width), s);
  const Normalization& n = geometry.normalization();
  int pixels = 0;
  for (double t = 0; t <= 1; t += 0.002) {
    const Vec3d at = rays.frame_place(rays.in_camera(n.point(Vec3d{-4, -2, 0.5} + Vec3d{8, 1.3, 0.4} * t)));
    if (!(at.x >= 0 && at.y >= 0 && at.x < kWidth && at.y < kHeight)) continue;
    ++pixels;
    EXPECT_TRUE(map->may_show_edge(uint32_t(at.x), uint32_t(at.y))) << t;
  }
  EXPECT_GT(pixels, 300);
}

TEST(EdgeMap, KnowsWhereRaysGo) {
  // A point of a ray through (x, y) lies there again, before a camera of either kind that is turned and
  // moved.
  const Geometry geometry = shapes();
  for (CameraKind kind : {CameraKind::kPerspective, CameraKind::kOrthographic}) {
    const CameraRays rays(camera(kind), geometry.normalization(), kWidth, kHeight);
    for (double x : {0.0, 7.3, 48.0})
      for (double y : {-2.0, 11.1, 36.0}) {
        const Ray ray = rays.through(x, y);
        const Vec3d place = rays.frame_place(rays.in_camera(ray.origin + ray.direction * 3.7));
        EXPECT_NEAR(place.x, x, 1e-9);
        EXPECT_NEAR(place.y, y, 1e-9);
      }
  }
}

TEST(EdgeMap, MarksLuminairesThatTheCameraSees) {
  const Geometry geometry = shapes();
  const RenderSettings s = settings();
  const CameraRays rays(camera(CameraKind::kPerspective), geometry.normalization(), kWidth, kHeight);
  const auto lamp = [&](const Vec3d& place) {
    LuminaireRole role;
    role.to_camera = true;
    const AreaLuminaire area{.name = "lamp",
                             .shape = LuminaireShape::kRectangle,
                             .world_from_light = at(place, 1),
                             .size_x = 0.05,
                             .size_y = 0.05,
                             .radiance = {1, 1, 1},
                             .role = role};
    return std::vector<Luminaire>{Luminaire(area, geometry.normalization())};
  };
  const PixelFilter filter(s.filter_type, s.filter_width);
  const auto marked = [&](const auto& map) {
    int count = 0;
    for (uint32_t i = 0; i < kWidth * kHeight; ++i) count += map->may_show_edge(i % kWidth, i / kWidth);
    return count;
  };
  const Vec3d place{-2.5, -2, 0.9};
  const auto without = make_edge_map(geometry, rays, {}, filter, s),
             with = make_edge_map(geometry, rays, lamp(place), filter, s),
             behind = make_edge_map(geometry, rays, lamp({3, -30, 20}), filter, s);
  const Vec3d seen = rays.frame_place(rays.in_camera(geometry.normalization().point(place)));
  EXPECT_TRUE(with->may_show_edge(uint32_t(seen.x), uint32_t(seen.y)));
  EXPECT_GT(marked(with), marked(without));
  EXPECT_EQ(marked(behind), marked(without));
}

}  // namespace
}  // namespace penumbra
