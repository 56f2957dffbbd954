// SPDX-License-Identifier: GPL-3.0-or-later
// Surface points against a long double intersection with the world-space triangle that was given to the
// scene, and normals against the inverse transpose. Vertices are rounded once to single precision, in a space
// where the scene spans about -1 ... 1: half an ulp of 1, 2^-24 of the scene's half extent, a coordinate.
// Where a ray meets the moved plane at 60 degrees or steeper, the point moves by no more than a few of these:
// 2^-21 is the tolerance for positions.
#include <gtest/gtest.h>

#include "oracles.h"
#include "small_scene.h"
#include "visibility/geometry.h"

namespace penumbra {
namespace {

using test::first_surface;
using test::Trials;

/// Where the line meets the plane of a, b, c; everything in long double.
Vec3<long double> meet(const Vec3d& o, const Vec3d& d, const Vec3d& a, const Vec3d& b, const Vec3d& c,
                       long double& t) {
  using Vec = Vec3<long double>;
  const Vec n = cross(Vec(b) - Vec(a), Vec(c) - Vec(a));
  t = dot(n, Vec(a) - Vec(o)) / dot(n, Vec(d));
  return Vec(o) + Vec(d) * t;
}

Mesh triangle(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  Mesh m;
  m.name = "triangle";
  m.positions = {a, b, c};
  m.triangles = {{0, 1, 2}};
  return m;
}

TEST(Geometry, SurfacePointsLieWhereTheRayMeetsTheTriangle) {
  Trials trials(1);
  for (double scale : {1e-6, 1.0, 1e4})
    for (double offset : {0.0, 1.0, 1e3}) {  // in units of the scale
      const Vec3d place{offset * scale, -offset * scale / 2, offset * scale / 3};
      for (int trial = 0; trial < 200; ++trial) {
        const Vec3d n = trials.direction(), u = normalize(cross(n, trials.direction())), v = cross(n, u);
        const auto at = [&](double x, double y) { return place + (u * x + v * y) * scale; };
        const Vec3d a = at(-1, -1), b = at(1, -0.8), c = at(0.1, 1);
        const Geometry geometry = test::place({triangle(a, b, c)});
        const Vec3d target = a * 0.3 + b * 0.3 + c * 0.4, sideways = cross(n, trials.direction()) * 0.5;
        const Vec3d origin = target + (n + sideways) * scale, direction = (target - origin) * 0.7;
        SurfacePoint s;
        ASSERT_TRUE(first_surface(geometry, origin, direction, s));
        long double t;
        const Vec3d exact(meet(origin, direction, a, b, c, t));
        const double tolerance = 0x1p-21 * scale;
        // Coordinates at the offset have themselves an ulp of double.
        EXPECT_LE(max_abs(geometry.normalization().world_point(s.position) - exact),
                  tolerance + 4e-16 * max_abs(place));
        EXPECT_NEAR(s.t, double(t), tolerance / length(direction));
        EXPECT_LE(max_abs(s.geometric_normal - n * (dot(n, direction) > 0 ? -1.0 : 1.0)), 1e-6);
      }
    }
}

TEST(Geometry, VerticesExactInSinglePrecisionGivePointsExactToDouble) {
  // Coordinates are multiples of 1/256 up to 1 and the scene's box is -1 ... 1: nothing is rounded on the
  // way.
  Trials trials(2);
  const auto grid = [&] {
    const auto g = [&] { return std::round(trials.uniform(-1, 1) * 256) / 256; };
    return Vec3d{g(), g(), g()};
  };
  int hits = 0;
  for (int trial = 0; trial < 500; ++trial) {
    const Vec3d a = grid(), b = grid(), c = grid(), n = cross(b - a, c - a);
    if (length(n) < 0.1) continue;
    // The box's corners as points of an unused vertex pair: a sliver far from the ray.
    Mesh m = triangle(a, b, c);
    m.positions.push_back({-1, -1, -1});
    m.positions.push_back({1, 1, 1});
    const Geometry geometry = test::place({m});
    ASSERT_EQ(geometry.normalization().scale, 1.0);
    const Vec3d target = (a + b + c) / 3.0, origin = target + normalize(n) + trials.vector(0.3);
    SurfacePoint s;
    if (!first_surface(geometry, origin, target - origin, s)) continue;
    ++hits;
    long double t;
    const Vec3d exact(meet(origin, target - origin, a, b, c, t));
    EXPECT_LE(max_abs(s.position - exact), 1e-13);
    EXPECT_NEAR(s.t, double(t), 1e-13);
  }
  EXPECT_GT(hits, 300);
}

/// An open box corner of three unit squares with smooth normals, to be seen from (1, 1, 1).
Mesh corner() {
  Mesh m;
  m.name = "corner";
  m.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 0}, {0, 1, 1}, {1, 0, 1}};
  m.triangles = {{0, 1, 4}, {0, 4, 2}, {0, 2, 5}, {0, 5, 3}, {0, 3, 6}, {0, 6, 1}};
  const Vec3f tilt(0.2f, 0.1f, 0.05f);
  for (const auto& t : m.triangles) {
    const Vec3f a(m.positions[t[0]]), b(m.positions[t[1]]), c(m.positions[t[2]]), n = cross(b - a, c - a);
    for (int k = 0; k < 3; ++k) m.corner_normals.push_back(normalize(n + tilt * float(k)));
  }
  return m;
}

struct WorldTriangle {
  Vec3d a, b, c;
};

/// Of the instance's triangles that the ray meets, the nearest; brute force in double.
int nearest(const Mesh& mesh, const Affine& world, const Vec3d& o, const Vec3d& d, double margin,
            WorldTriangle& out) {
  int best = -1;
  double best_t = 1e30;
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& t = mesh.triangles[i];
    const WorldTriangle w{world.point(mesh.positions[t[0]]), world.point(mesh.positions[t[1]]),
                          world.point(mesh.positions[t[2]])};
    const Vec3d e1 = w.b - w.a, e2 = w.c - w.a, p = cross(d, e2), s = o - w.a, q = cross(s, e1);
    const double det = dot(e1, p), u = dot(s, p) / det, v = dot(d, q) / det, time = dot(e2, q) / det;
    if (time < 0 || u < -margin || v < -margin || u + v > 1 + margin) continue;
    if (u < margin || v < margin || u + v > 1 - margin) return -1;  // too near an edge to say
    if (time < best_t) best_t = time, best = int(i), out = w;
  }
  return best;
}

/// The corner normals of a triangle at a point of it (object space), placed by the inverse transpose: each
/// corner placed and then interpolated, or interpolated in object space and then placed.
Vec3d smooth_normal(const Mesh& mesh, size_t index, const Affine& world, const Vec3d& local,
                    bool in_object_space) {
  const auto& t = mesh.triangles[index];
  const Vec3d a = mesh.positions[t[0]], e1 = mesh.positions[t[1]] - a, e2 = mesh.positions[t[2]] - a;
  const Vec3d facet = cross(e1, e2);
  const double area = dot(facet, facet);
  const double u = dot(cross(local - a, e2), facet) / area, v = dot(cross(e1, local - a), facet) / area;
  const double weights[3] = {1 - u - v, u, v};
  // Inverse transpose: n' . (M w) = n . w for all w; cofactors divided by the determinant.
  const auto placed = [&](const Vec3d& n) { return normalize(world.normal(n) * (1 / world.determinant())); };
  Vec3d sum;
  for (int k = 0; k < 3; ++k) {
    const Vec3d corner(mesh.corner_normals[3 * index + size_t(k)]);
    sum += (in_object_space ? corner : placed(corner)) * weights[k];
  }
  return in_object_space ? placed(sum) : normalize(sum);
}

class Normals : public ::testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(SingleAndShared, Normals, ::testing::Bool());

TEST_P(Normals, FollowMirroredAndUnevenInstances) {
  // Geometric: perpendicular to the transformed triangle, on the viewer's side. Smooth: placed by the inverse
  // transpose and turned to the same side as their own facet; as in Cycles a shared mesh interpolates in
  // object space, one used once where it is placed. Vertices rounded by 2^-24 of the scene turn a facet by
  // 1e-6 or so, up to ten times that where the transform squeezes it.
  const bool shared = GetParam();
  Trials trials(3);
  int seen = 0, mirrored = 0;
  for (int trial = 0; trial < 400; ++trial) {
    const Affine world = trials.transform(3);
    const Mesh mesh = corner();
    std::vector<Instance> instances{{"one", 0, world, {0}}};
    if (shared) instances.push_back({"two", 0, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {20, 0, 0}}, {0}});
    const Geometry geometry({mesh}, instances);
    const Vec3d target = world.point({0.3, 0.4, 0.2}), d = trials.direction(), origin = target - d * 3.0;
    WorldTriangle w;
    const int index = nearest(mesh, world, origin, d, 1e-4, w);
    SurfacePoint s;
    if (index < 0 || !first_surface(geometry, origin, d, s)) continue;
    const Vec3d n = normalize(cross(w.b - w.a, w.c - w.a));
    if (std::abs(dot(n, d)) < 0.1) continue;  // grazing: the position's rounding grows
    ++seen;
    mirrored += world.determinant() < 0;
    EXPECT_LE(max_abs(s.geometric_normal - (dot(n, d) > 0 ? -n : n)), 1e-4) << "trial " << trial;

    const auto& t = mesh.triangles[size_t(index)];
    const Vec3d a = mesh.positions[t[0]], facet = cross(mesh.positions[t[1]] - a, mesh.positions[t[2]] - a);
    const Vec3d local = world.inverse_point(geometry.normalization().world_point(s.position));
    Vec3d smooth = smooth_normal(mesh, size_t(index), world, local, shared);
    if (dot(world.normal(facet) * (1 / world.determinant()), d) > 0) smooth = -smooth;
    EXPECT_LE(max_abs(s.normal - smooth), 2e-4) << "trial " << trial;
  }
  EXPECT_GT(seen, 150);
  EXPECT_GT(mirrored, 40);
}

TEST(Geometry, SharedAndFlattenedMeshesGiveTheSamePoints) {
  // Three instances of one mesh against three copies of it, used once each. The shared mesh's own space is
  // rounded once more: 2^-20 of the scene's half extent.
  Trials trials(4);
  int compared = 0;
  for (int trial = 0; trial < 60; ++trial) {
    std::vector<Instance> shared, single;
    std::vector<Mesh> copies;
    for (uint32_t i = 0; i < 3; ++i) {
      Affine world = trials.transform(2);
      if (trial % 2) {  // a rotation and a scale
        const double size = length(world.x_axis);
        world.x_axis = normalize(world.x_axis);
        world.y_axis = normalize(cross(world.z_axis, world.x_axis));
        world.z_axis = cross(world.x_axis, world.y_axis) * size;
        world.x_axis = world.x_axis * size;
        world.y_axis = world.y_axis * size;
      }
      shared.push_back({"instance", 0, world, {i}});
      single.push_back({"copy", i, world, {i}});
      copies.push_back(corner());
    }
    const Geometry a({corner()}, shared), b(copies, single);
    EXPECT_TRUE(a.has_shared_meshes());
    EXPECT_FALSE(b.has_shared_meshes());
    EXPECT_EQ(a.triangles(), b.triangles());
    for (int k = 0; k < 50; ++k) {
      const Vec3d target = shared[k % 3].world_from_object.point({0.5, 0.3, 0.2}), d = trials.direction();
      SurfacePoint p, q;
      const bool hit = first_surface(a, target - d * 4.0, d, p);
      // Near an edge one may slip past the other; that is rare and not what this test is about.
      if (!first_surface(b, target - d * 4.0, d, q) || !hit || p.material != q.material ||
          std::abs(p.t - q.t) > 1e-3)
        continue;
      if (std::abs(dot(q.geometric_normal, d)) < 0.1) continue;
      ++compared;
      const double tolerance = 0x1p-20 / a.normalization().scale / std::abs(dot(q.geometric_normal, d));
      EXPECT_LE(max_abs(p.position - q.position) / a.normalization().scale, tolerance);
      EXPECT_LE(max_abs(p.geometric_normal - q.geometric_normal), 1e-4);
      // A shared mesh's normals are interpolated in its own space, the other's where it is placed: the same
      // as long as the transform keeps angles.
      if (trial % 2) {
        EXPECT_LE(max_abs(p.normal - q.normal), 1e-4);
      }
    }
  }
  EXPECT_GT(compared, 1000);
}

TEST(Geometry, NothingToHit) {
  const Geometry empty({}, {});
  SurfacePoint s;
  EXPECT_FALSE(first_surface(empty, {0, 0, 1}, {0, 0, -1}, s));
  // Zero scale: not seen, and no failure.
  const Geometry flat({corner()}, {{"zero", 0, {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {1, 1, 1}}, {0}}});
  EXPECT_FALSE(first_surface(flat, {1, 1, 4}, {0, 0, -1}, s));
  // Rays that must never reach Embree.
  const Geometry floor = test::place({test::quad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0})});
  const double bad[] = {std::nan(""), INFINITY, -INFINITY};
  for (double b : bad) {
    EXPECT_FALSE(first_surface(floor, {b, 0, 1}, {0, 0, -1}, s));
    EXPECT_FALSE(first_surface(floor, {0, 0, 1}, {0, 0, b}, s));
  }
  EXPECT_FALSE(first_surface(floor, {0, 0, 1}, {0, 0, 0}, s));
}

TEST(Geometry, MaterialsGoBySlot) {
  Mesh m = test::quad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0});
  m.material_slots = {0, 7};
  const Geometry geometry({m}, {{"two", 0, {}, {4, 9}}});
  SurfacePoint s;
  ASSERT_TRUE(first_surface(geometry, {0.5, -0.5, 1}, {0, 0, -1}, s));
  EXPECT_EQ(s.material, 4u);
  ASSERT_TRUE(first_surface(geometry, {-0.5, 0.5, 1}, {0, 0, -1}, s));
  EXPECT_EQ(s.material, 9u);  // beyond the end: the last one
}

}  // namespace
}  // namespace penumbra
