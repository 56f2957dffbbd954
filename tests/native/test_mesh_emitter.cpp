// SPDX-License-Identifier: GPL-3.0-or-later
// Emissive meshes. Oracles: Lambert's formula triangle by triangle, and the sphere's closed form.
#include <gtest/gtest.h>

#include "luminaire/luminaire.h"
#include "luminaire/mesh_order.h"
#include "oracles.h"

namespace penumbra {
namespace {

using test::kPi;
using test::surface_at;
using test::Trials;

/// Latitude and longitude, outward, closed; 2 x segments x (segments / 2 - 1) triangles.
MeshLuminaire ball(double radius, uint32_t segments) {
  MeshLuminaire mesh{"ball", {}, {}, {1, 1, 1}};
  const uint32_t rings = segments / 2;
  for (uint32_t i = 1; i < rings; ++i)
    for (uint32_t k = 0; k < segments; ++k) {
      const double theta = kPi * i / rings, phi = 2 * kPi * k / segments;
      mesh.positions.push_back(
          Vec3d{std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)} * radius);
    }
  const auto at = [&](uint32_t i, uint32_t k) { return i * segments + k % segments; };
  const auto north = uint32_t(mesh.positions.size()), south = north + 1;
  mesh.positions.push_back({0, 0, radius});
  mesh.positions.push_back({0, 0, -radius});
  for (uint32_t k = 0; k < segments; ++k) {
    mesh.triangles.push_back({north, at(0, k), at(0, k + 1)});
    mesh.triangles.push_back({south, at(rings - 2, k + 1), at(rings - 2, k)});
    for (uint32_t i = 0; i + 2 < rings; ++i) {
      mesh.triangles.push_back({at(i, k), at(i + 1, k), at(i + 1, k + 1)});
      mesh.triangles.push_back({at(i, k), at(i + 1, k + 1), at(i, k + 1)});
    }
  }
  return mesh;
}

double lambert(const MeshLuminaire& mesh, const Vec3d& point, const Vec3d& n, bool one_sided) {
  double sum = 0;
  for (const auto& t : mesh.triangles) {
    const Vec3d &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
    if (one_sided && dot(point - a, cross(b - a, c - a)) <= 0) continue;
    sum += test::lambert_form_factor({a, b, c}, point, n);
  }
  return sum;
}

/// The mean over 65536 Hammersley points.
double sampled(const Luminaire& luminaire, const SurfacePoint& surface) {
  LightPoints points;
  alignas(64) float u[kBatch], v[kBatch];
  double sum = 0;
  for (uint32_t first = 0; first < 65536; first += kBatch) {
    for (uint32_t i = 0; i < kBatch; ++i) {
      u[i] = (float(first + i) + 0.5f) / 65536;
      uint32_t reversed = 0;
      for (uint32_t bit = 0; bit < 16; ++bit) reversed |= ((first + i) >> bit & 1) << (15 - bit);
      v[i] = float(reversed) / 65536;
    }
    luminaire.evaluate(surface, u, v, kBatch, points);
    for (float f : points.form_factor) sum += double(f);
  }
  return sum / 65536;
}

TEST(Mesh, BallsAreTheirTriangles) {
  // Closed: seen from outside one side counts. Far triangles by three points: 2e-4 of the whole.
  Trials trials(41);
  int cut = 0;
  for (int trial = 0; trial < 150; ++trial) {
    const MeshLuminaire mesh = ball(0.5, trial % 3 ? 32 : 8);
    const Luminaire luminaire(mesh, {});
    const Vec3d way = trials.direction(), point = way * trials.uniform(0.9, 4), n = trials.direction();
    const double exact = lambert(mesh, point, n, true), f = luminaire.form_factor(surface_at(point, n));
    const double facing = lambert(mesh, point, -way, true);
    EXPECT_NEAR(f, exact, 2e-4 * facing) << "trial " << trial;
    if (luminaire.unseen_from(surface_at(point, n))) {
      EXPECT_EQ(exact, 0);
    }
    cut += exact > 0 && exact < 0.5 * facing;
  }
  EXPECT_GT(cut, 30);
}

TEST(Mesh, FineBallsAreSpheres) {
  // 64 segments: the area falls short by about (2 pi / 64)^2 / 6 x 2 = 3e-3.
  const Luminaire mesh(ball(0.5, 64), {});
  PointLuminaire description{"sphere", RoundShape::kSphere, {}, 0.5, {1, 1, 1}, true, {}};
  const Luminaire sphere(description, {});
  Trials trials(42);
  for (int trial = 0; trial < 50; ++trial) {
    const Vec3d way = trials.direction(), point = way * trials.uniform(1.2, 3);
    const Vec3d n = normalize(trials.direction() * 0.8 - way);
    const double exact = sphere.form_factor(surface_at(point, n)) * kPi * 0.25;
    EXPECT_NEAR(mesh.form_factor(surface_at(point, n)), exact, 5e-3 * exact + 1e-4);
  }
}

TEST(Mesh, PointsAverageToTheFormFactor) {
  // Uniform in area, half of them face away: 5e-3 where a ball is one radius away.
  Trials trials(43);
  for (int trial = 0; trial < 40; ++trial) {
    MeshLuminaire mesh = ball(0.5, 16);
    if (trial % 2) mesh.triangles.resize(mesh.triangles.size() / 2);  // open: both sides count
    const Luminaire luminaire(mesh, {});
    const Vec3d way = trials.direction(), point = way * trials.uniform(1, 3);
    const Vec3d n = normalize(trials.direction() * 0.8 - way);
    const double exact = lambert(mesh, point, n, trial % 2 == 0);
    EXPECT_NEAR(luminaire.form_factor(surface_at(point, n)), exact, 5e-4 * exact + 1e-6);
    EXPECT_NEAR(sampled(luminaire, surface_at(point, n)), exact, 5e-3 * exact) << "trial " << trial;
  }
}

TEST(Mesh, InsideOutOrMirroredBallsAreTheSame) {
  const MeshLuminaire mesh = ball(0.5, 16);
  MeshLuminaire turned = mesh, two = mesh;
  for (auto& t : turned.triangles) std::swap(t[0], t[1]);
  // Two parts, one of them inside out.
  for (const Vec3d& p : mesh.positions) two.positions.push_back(p + Vec3d{5, 0, 0});
  for (auto t : turned.triangles) {
    for (uint32_t& corner : t) corner += uint32_t(mesh.positions.size());
    two.triangles.push_back(t);
  }
  const SurfacePoint here = surface_at({0, 0, -2}, {0, 0, 1}), there = surface_at({5, 0, -2}, {0, 0, 1});
  const double f = Luminaire(mesh, {}).form_factor(here);
  EXPECT_NEAR(Luminaire(turned, {}).form_factor(here), f, 1e-5);
  const Luminaire both(two, {});
  EXPECT_NEAR(both.form_factor(here), both.form_factor(there), 1e-5);
  EXPECT_GT(both.form_factor(here), f);
}

TEST(Mesh, InsideAClosedMeshIsAFurnace) {
  const Luminaire luminaire(ball(2, 24), {});
  Trials trials(44);
  for (int trial = 0; trial < 20; ++trial)
    EXPECT_NEAR(luminaire.form_factor(surface_at(trials.direction() * 0.8, trials.direction())), 1, 1e-3);
}

TEST(Mesh, ClosedMeansEveryEdgeTwice) {
  MeshLuminaire mesh = ball(1, 8);
  EXPECT_TRUE(is_closed(mesh.triangles));
  std::swap(mesh.triangles[3][0], mesh.triangles[3][1]);
  EXPECT_FALSE(is_closed(mesh.triangles));
  mesh.triangles.erase(mesh.triangles.begin() + 3);
  EXPECT_FALSE(is_closed(mesh.triangles));
}

TEST(Mesh, FlatAndEmptyOnesAreDark) {
  EXPECT_TRUE(Luminaire(MeshLuminaire{"none", {}, {}, {1, 1, 1}}, {}).dark());
  EXPECT_TRUE(
      Luminaire(MeshLuminaire{"line", {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1, 2}}, {1, 1, 1}}, {}).dark());
}

TEST(Mesh, WeightedTrianglesAddUp) {
  // Oracle: Lambert's formula for each triangle times its weight, on both sides or on one; the mean of
  // sampled points, which go where the weight is.
  Trials trials(47);
  for (int trial = 0; trial < 40; ++trial) {
    MeshLuminaire mesh = ball(0.5, 8);
    mesh.one_sided = trial % 2;
    mesh.triangles.resize(mesh.triangles.size() / 2);  // a part of the ball: it has no inside
    for (size_t i = 0; i < mesh.triangles.size(); ++i)
      mesh.weights.push_back(i % 5 == 0 ? 0.0f : float(trials.uniform(0.1, 4)));
    const Luminaire luminaire(mesh, {});
    const Vec3d point = trials.direction() * trials.uniform(0.9, 4), n = trials.direction();
    double exact = 0, facing = 0;
    for (size_t i = 0; i < mesh.triangles.size(); ++i) {
      MeshLuminaire one = mesh;
      one.triangles = {mesh.triangles[i]};
      exact += double(mesh.weights[i]) * lambert(one, point, n, mesh.one_sided);
      facing += double(mesh.weights[i]) * lambert(one, point, normalize(-point), mesh.one_sided);
    }
    EXPECT_NEAR(luminaire.form_factor(surface_at(point, n)), exact, 3e-4 * facing) << "trial " << trial;
    EXPECT_NEAR(sampled(luminaire, surface_at(point, n)), exact, 3e-3 * facing) << "trial " << trial;
  }
}

}  // namespace
}  // namespace penumbra
