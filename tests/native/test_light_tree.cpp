// SPDX-License-Identifier: GPL-3.0-or-later
// Many luminaires in a tree. Oracle: each luminaire's own form factor, summed.
#include <gtest/gtest.h>

#include "luminaire/light_group.h"
#include "luminaire/light_tree.h"
#include "many_luminaires.h"
#include "oracles.h"

namespace penumbra {
namespace {

using test::exact_sum;
using test::kUnshared;
using test::many;
using test::mean_of_points;
using test::surface_at;
using test::Trials;

SurfacePoint somewhere(Trials& trials, double half = 1.2) {
  return surface_at({trials.uniform(-half, half), trials.uniform(-half, half), trials.uniform(-half, half)},
                    trials.direction());
}

/// The luminaires of a node as append() makes them; with many elements to a node they are groups.
Vec3d sum_of(const LightTree& tree, uint32_t node, const SurfacePoint& surface) {
  std::vector<Luminaire> groups;
  tree.append(node, kUnshared, groups);
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
  tree.append(tree.roots()[0], kUnshared, groups);
  ASSERT_EQ(groups.size(), 1u);
  for (int i = 0; i < 20; ++i) {
    const SurfacePoint surface = somewhere(trials);
    const double mean = mean_of_points(groups[0], surface, trials);
    const double exact = groups[0].form_factor(surface);
    if (exact == 0) {
      EXPECT_EQ(mean, 0);
      continue;
    }
    EXPECT_NEAR(mean / exact, 1, 0.01);
  }
}

/// Oracle: the same group asked for one surface point. Few elements go through columns, many one by one; `u`
/// may be rounded to 1.
TEST(LightTree, ManySurfacePointsGetWhatEachGets) {
  for (const int count : {2, 7, 40, 47, 48, 120}) {
    Trials trials{uint32_t(count)};
    const LightTree tree(many(count, trials));
    std::vector<Luminaire> groups;
    tree.append(tree.roots()[0], kUnshared, groups);
    double sent = 0;
    for (const Luminaire& group : groups) {
      SurfaceColumns surfaces;
      for (int i = 0; i < 16; ++i) surfaces.add(somewhere(trials, 2));
      alignas(64) float u[kBatch], v[kBatch];
      for (uint32_t i = 0; i < kBatch; ++i)
        u[i] = i % 9 ? float(trials.uniform(0, 1)) : 1.0f, v[i] = float(trials.uniform(0, 1));
      alignas(64) double form_factors[kBatch];
      LightPoints all, own;
      group.form_factors(surfaces, form_factors);
      group.evaluate_each(surfaces, u, v, all, 4);
      for (uint32_t i = 0; i < surfaces.count; ++i) {
        EXPECT_EQ(form_factors[i], group.form_factor(surfaces.point(i))) << count;
        alignas(64) float own_u[4], own_v[4];
        for (uint32_t k = 0; k < 4; ++k) own_u[k] = u[k * 16 + i], own_v[k] = v[k * 16 + i];
        group.evaluate(surfaces.point(i), own_u, own_v, 4, own);
        for (uint32_t k = 0; k < 4; ++k) {
          EXPECT_EQ(all.form_factor[k * 16 + i], own.form_factor[k]) << count;
          EXPECT_EQ(all.x[k * 16 + i], own.x[k]) << count;
          sent += double(own.form_factor[k]);
        }
      }
    }
    EXPECT_GT(sent, 0);
  }
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
    tree.append(root, kUnshared, groups);
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
