// SPDX-License-Identifier: GPL-3.0-or-later
// Many luminaires in a tree. Oracle: each luminaire's own form factor, summed.
#include <gtest/gtest.h>

#include "luminaire/light_group.h"
#include "luminaire/light_tree.h"
#include "oracles.h"

namespace penumbra {
namespace {

using test::kPi;
using test::surface_at;
using test::Trials;

Affine turned(Trials& trials, const Vec3d& at, double scale) {
  const Vec3d z = trials.direction();
  const Vec3d x = normalize(cross(z, std::abs(z.x) < 0.5 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0}));
  return {x * scale, cross(z, x) * scale, z * scale, at};
}

MeshLuminaire tetrahedron(const Affine& t, const Vec3d& radiance, bool closed) {
  MeshLuminaire mesh{"tetrahedron", {}, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}}, radiance};
  if (closed) mesh.triangles.push_back({0, 3, 2});
  for (const Vec3d& p : {Vec3d{0, 0, 0}, Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}})
    mesh.positions.push_back(t.point(p));
  return mesh;
}

/// Of every kind, in the cube [-1, 1]^3.
std::vector<Luminaire> many(uint32_t count, Trials& trials, bool colours = true, bool beams = true) {
  std::vector<Luminaire> luminaires;
  const Normalization n{};
  for (uint32_t i = 0; i < count; ++i) {
    const Vec3d at{trials.uniform(-1, 1), trials.uniform(-1, 1), trials.uniform(-1, 1)};
    const double size = trials.uniform(0.005, 0.05), bright = trials.uniform(1, 5);
    const Vec3d radiance = colours && i % 2 ? Vec3d{bright, bright / 2, 0} : Vec3d{bright, bright, bright};
    const Affine t = turned(trials, at, size);
    LuminaireDescription d;
    switch (beams ? i % 6 : i % 5) {
      case 0:
        d = AreaLuminaire{"rectangle", LuminaireShape::kRectangle, t, 1, trials.uniform(0.2, 1), radiance};
        break;
      case 1:
        d = AreaLuminaire{"ellipse", LuminaireShape::kEllipse, t, 1, trials.uniform(0.2, 1), radiance};
        break;
      case 2:
        d = PointLuminaire{"bulb", RoundShape::kSphere, t, i % 4 ? 0.0 : size, radiance * (size * size), true,
                           {}};
        break;
      case 3:
        d = PointLuminaire{"spot", RoundShape::kFacingDisk, t, size, radiance * (size * size), true, {}};
        if (beams && i % 4 == 1) std::get<PointLuminaire>(d).spot = SpotCone{1.0, 0.5};
        break;
      case 4:
        d = tetrahedron(t, radiance, i % 4 == 0);
        break;
      default:
        d = AreaLuminaire{"soft box", LuminaireShape::kRectangle, t, 1, 1, radiance, true, 1.5};
    }
    luminaires.emplace_back(d, n);
  }
  return luminaires;
}

SurfacePoint somewhere(Trials& trials, double half = 1.2) {
  return surface_at({trials.uniform(-half, half), trials.uniform(-half, half), trials.uniform(-half, half)},
                    trials.direction());
}

Vec3d exact_sum(const std::vector<Luminaire>& luminaires, const SurfacePoint& surface) {
  Vec3d sum;
  for (const Luminaire& l : luminaires) sum += l.radiance() * l.form_factor(surface);
  return sum;
}

/// The luminaires of a node as append() makes them; with many elements to a node they are groups.
Vec3d sum_of(const LightTree& tree, uint32_t node, const SurfacePoint& surface) {
  std::vector<Luminaire> groups;
  tree.append(node, groups);
  EXPECT_EQ(groups.size() <= 1 || groups.size() <= tree.count(node), true);
  return exact_sum(groups, surface);
}

TEST(LightTree, GroupsShineAsTheirLuminaires) {
  Trials trials(1);
  const std::vector<Luminaire> luminaires = many(300, trials);
  const LightTree tree(luminaires);
  ASSERT_EQ(tree.roots().size(), 1u);
  double worst = 0;
  for (int i = 0; i < 400; ++i) {
    const SurfacePoint surface = somewhere(trials);
    const Vec3d exact = exact_sum(luminaires, surface), sum = sum_of(tree, tree.roots()[0], surface);
    if (exact.x == 0) continue;
    worst = std::max({worst, std::abs(sum.x / exact.x - 1), std::abs(sum.y / exact.y - 1)});
  }
  EXPECT_LT(worst, 5e-4);
}

/// In units of what the luminaire would send if it and the surface faced each other: near a horizon, where
/// hardly any of that comes, relative errors are larger.
TEST(LightTree, EachElementKeepsItsError) {
  Trials trials(2);
  double worst = 0, mean = 0;
  int count = 0;
  for (int i = 0; i < 3000; ++i) {
    const std::vector<Luminaire> all = many(6, trials);
    const std::vector<Luminaire> two{all[size_t(i % 6)], all[size_t(i % 6)]};  // a group
    const LightTree tree(two);
    const SurfacePoint surface = somewhere(trials);
    const double exact = exact_sum(two, surface).x, sum = sum_of(tree, tree.roots()[0], surface).x;
    if (exact == 0) {
      EXPECT_EQ(sum, 0);
      continue;
    }
    double facing = 0;
    for (const Luminaire& l : two)
      for (const LightElement& e : l.elements()) {
        const Vec3d to_light = e.centre - surface.position;
        facing += l.radiance().x * e.strength / dot(to_light, to_light);
      }
    const double error = std::abs(sum - exact) / facing;
    worst = std::max(worst, error);
    mean += error;
    ++count;
  }
  EXPECT_LT(worst, 1e-3);
  EXPECT_LT(mean / count, 5e-5);
}

TEST(LightTree, BoundsAreNeverBelow) {
  Trials trials(3);
  for (int scene = 0; scene < 20; ++scene) {
    const std::vector<Luminaire> luminaires = many(60, trials);
    const LightTree tree(luminaires);
    for (int i = 0; i < 200; ++i) {
      const SurfacePoint surface = somewhere(trials, i % 2 ? 1.2 : 5.0);
      std::vector<uint32_t> open = tree.roots();
      while (!open.empty()) {
        const uint32_t index = open.back();
        open.pop_back();
        const LightNode& node = tree.node(index);
        const Vec3d bound = node.bound(surface), sum = sum_of(tree, index, surface);
        // 32 x 32 points of a soft box may be off by so much.
        for (int c = 0; c < 3; ++c) ASSERT_LE(sum[c], bound[c] * 1.001) << index;
        if (!node.is_leaf()) {
          open.push_back(index + 1);
          open.push_back(node.right);
        }
      }
    }
  }
}

TEST(LightTree, FarBoundsAreClose) {
  Trials trials(4);
  std::vector<Luminaire> lamps;
  for (int i = 0; i < 100; ++i)
    lamps.emplace_back(
        AreaLuminaire{
            "lamp",
            LuminaireShape::kRectangle,
            Affine{
                {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {trials.uniform(-0.1, 0.1), trials.uniform(-0.1, 0.1), 0.5}},
            0.01,
            0.01,
            {1, 1, 1}},
        Normalization{});
  const LightTree tree(lamps);
  const SurfacePoint below = surface_at({0, 0, -0.9}, {0, 0, 1}), above = surface_at({0, 0, 0.9}, {0, 0, 1}),
                     turned_away = surface_at({0, 0, -0.9}, {0, 0, -1});
  const LightNode& root = tree.node(tree.roots()[0]);
  EXPECT_LT(root.bound(below).x, 1.1 * exact_sum(lamps, below).x);
  EXPECT_EQ(root.bound(above).x, 0);
  EXPECT_EQ(root.bound(turned_away).x, 0);
}

TEST(LightTree, PointsOfAGroupHaveItsFormFactorAsMean) {
  Trials trials(5);
  const std::vector<Luminaire> luminaires = many(90, trials, false);
  const LightTree tree(luminaires);
  std::vector<Luminaire> groups;
  tree.append(tree.roots()[0], groups);
  ASSERT_EQ(groups.size(), 1u);
  for (int i = 0; i < 20; ++i) {
    const SurfacePoint surface = somewhere(trials);
    LightPoints points;
    alignas(64) float u[kBatch], v[kBatch];
    constexpr uint32_t kPoints = 1 << 16;
    double sum = 0;
    for (uint32_t first = 0; first < kPoints; first += kBatch) {
      for (uint32_t k = 0; k < kBatch; ++k) {
        u[k] = (float(first + k) + 0.5f) / kPoints;
        v[k] = float(trials.uniform(0, 1));
      }
      groups[0].evaluate(surface, u, v, kBatch, points);
      for (float f : points.form_factor) sum += double(f);
    }
    const double exact = groups[0].form_factor(surface);
    if (exact == 0) {
      EXPECT_EQ(sum, 0);
      continue;
    }
    EXPECT_NEAR(sum / kPoints / exact, 1, 0.01);
  }
}

/// Of facing light, as above: sums that are shared among neighbours, on one surface and around an edge.
TEST(LightTree, NeighboursShareSums) {
  Trials trials(7);
  double worst = 0;
  int shared = 0;
  for (int scene = 0; scene < 200; ++scene) {
    const std::vector<Luminaire> luminaires = many(60, trials, false, false);
    const LightTree tree(luminaires);
    std::vector<Luminaire> groups;
    tree.append(tree.roots()[0], groups);
    ASSERT_EQ(groups.size(), 1u);
    const double far = trials.uniform(2, 8);
    const Vec3d at = trials.direction() * far, n = normalize(-at + trials.direction() * (0.5 * far));
    SurfaceColumns columns;
    for (int i = 0; i < 16; ++i) {
      const Vec3d turned = i % 4 ? n : normalize(-at + trials.direction() * (0.5 * far));
      columns.add(surface_at(at + trials.direction() * (0.008 * far), turned));
    }
    double out[kBatch];
    groups[0].form_factors(columns, out);
    double facing = 0;
    for (const Luminaire& l : luminaires)
      for (const LightElement& e : l.elements()) facing += l.radiance().x * e.strength / (far * far);
    for (uint32_t i = 0; i < columns.count; ++i) {
      const double exact = groups[0].form_factor(columns.point(i));
      worst = std::max(worst, std::abs(out[i] - exact) * groups[0].radiance().x / facing);
      shared += out[i] != exact;
    }
  }
  EXPECT_GT(shared, 1500);   // of 3200
  EXPECT_LT(worst, 1.6e-3);  // four times the square of 0.02
}

TEST(LightTree, KeepsKindsApart) {
  Trials trials(6);
  std::vector<Luminaire> luminaires = many(12, trials);
  const Luminaire& first = luminaires[0];
  const size_t groupable = luminaires.size();
  std::vector<Luminaire> others;
  for (const Luminaire& l : luminaires)
    others.emplace_back("shadowless " + l.name(), std::shared_ptr<const Emitter>(&l.emitter(), [](auto*) {}),
                        l.radiance(), false);
  for (const Luminaire& l : luminaires)
    others.emplace_back("minus " + l.name(), std::shared_ptr<const Emitter>(&l.emitter(), [](auto*) {}),
                        -l.radiance(), true);
  others.emplace_back(SunLuminaire{"sun", {0, 0, 1}, 0.1, {1, 1, 1}}, Normalization{});
  std::vector<Luminaire> all = luminaires;
  all.insert(all.end(), others.begin(), others.end());
  const LightTree tree(all);
  EXPECT_EQ(tree.roots().size(), 3u);
  EXPECT_EQ(tree.rest().size(), 1u);
  EXPECT_EQ(groupable, 12u);
  const SurfacePoint surface = surface_at(first.elements()[0].centre + Vec3d{0.3, 0.2, -0.4}, {0, 0, 1});
  Vec3d with_shadow, without, minus;
  for (uint32_t root : tree.roots()) {
    std::vector<Luminaire> groups;
    tree.append(root, groups);
    for (const Luminaire& g : groups) {
      const Vec3d light = g.radiance() * g.form_factor(surface);
      (light.x < 0 || light.y < 0 || light.z < 0 ? minus : g.casts_shadow() ? with_shadow : without) += light;
    }
  }
  const Vec3d exact = exact_sum(luminaires, surface);
  EXPECT_GT(exact.x, 0);
  EXPECT_NEAR(with_shadow.x, exact.x, 5e-4 * exact.x);
  EXPECT_NEAR(without.x, exact.x, 5e-4 * exact.x);
  EXPECT_NEAR(minus.x, -exact.x, 5e-4 * exact.x);
}

}  // namespace
}  // namespace penumbra
