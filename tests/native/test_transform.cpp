// SPDX-License-Identifier: GPL-3.0-or-later
// Affine transforms and boxes. Tolerances: a few roundings of double (2^-53) times the condition of the
// matrices, which are drawn with |determinant| > 0.1 and entries of at most 1.
#include <gtest/gtest.h>

#include "math/transform.h"
#include "oracles.h"
#include "scene/normalization.h"

namespace penumbra {
namespace {

using test::Trials;

void expect_near(const Vec3d& a, const Vec3d& b, double tolerance) {
  EXPECT_LE(max_abs(a - b), tolerance)
      << a.x << " " << a.y << " " << a.z << " / " << b.x << " " << b.y << " " << b.z;
}

TEST(Affine, InverseUndoes) {
  Trials trials(1);
  for (int i = 0; i < 1000; ++i) {
    const Affine t = trials.transform(5);
    const Vec3d p = trials.vector(3);
    expect_near(t.inverse_point(t.point(p)), p, 1e-12);
    expect_near(t.inverse_vector(t.vector(p)), p, 1e-12);
  }
}

TEST(Affine, ProductAppliesTheRightOneFirst) {
  Trials trials(2);
  for (int i = 0; i < 1000; ++i) {
    const Affine a = trials.transform(5), b = trials.transform(5);
    const Vec3d p = trials.vector(3);
    expect_near((a * b).point(p), a.point(b.point(p)), 1e-13);
    EXPECT_NEAR((a * b).determinant(), a.determinant() * b.determinant(), 1e-13);
  }
}

TEST(Affine, NormalsStayPerpendicular) {
  // n . v = 0 must give normal(n) . vector(v) = 0; and n . (M^-1 w) |M| = normal(n) . w, which fixes length
  // and sign.
  Trials trials(3);
  for (int i = 0; i < 1000; ++i) {
    const Affine t = trials.transform(5);
    const Vec3d n = trials.direction(), v = cross(n, trials.direction()), w = trials.vector(1);
    EXPECT_NEAR(dot(t.normal(n), t.vector(v)), 0, 1e-14);
    EXPECT_NEAR(dot(t.normal(n), w), dot(n, t.inverse_vector(w)) * t.determinant(), 1e-13);
  }
}

TEST(Affine, NormalSurvivesASingularTransform) {
  const Affine flat{{1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {}};
  expect_near(flat.normal({0, 0, 1}), {0, 0, 1}, 0);
}

TEST(Affine, FiniteLooksAtEveryNumber) {
  for (int i = 0; i < 12; ++i) {
    Affine t;
    Vec3d* const columns[] = {&t.x_axis, &t.y_axis, &t.z_axis, &t.origin};
    Vec3d& c = *columns[i / 3];
    ASSERT_TRUE(t.finite());
    (i % 3 == 0 ? c.x : i % 3 == 1 ? c.y : c.z) = i % 2 ? std::nan("") : INFINITY;
    EXPECT_FALSE(t.finite()) << i;
  }
}

TEST(Box, GrowsAndHasEightCorners) {
  Box box;
  EXPECT_TRUE(box.empty());
  box.include(Box{});
  EXPECT_TRUE(box.empty());
  box.include(Vec3d{1, 2, 3});
  EXPECT_FALSE(box.empty());
  EXPECT_EQ(box.extent(), (Vec3d{0, 0, 0}));
  box.include(Vec3d{-1, 4, 3});
  EXPECT_EQ(box.low, (Vec3d{-1, 2, 3}));
  EXPECT_EQ(box.high, (Vec3d{1, 4, 3}));
  EXPECT_EQ(box.centre(), (Vec3d{0, 3, 3}));
  Box again;
  for (const Vec3d& c : box.corners()) again.include(c);
  EXPECT_EQ(again.low, box.low);
  EXPECT_EQ(again.high, box.high);
}

TEST(Normalization, GoesThereAndBackExactlyForPowersOfTwo) {
  const Normalization n{{0x1p20, 3, -5}, 0x1p10};
  for (const Vec3d& p : {Vec3d{0x1p20 + 0.125, 3, -5}, Vec3d{0x1p20, 3.5, -4}})
    EXPECT_EQ(n.world_point(n.point(p)), p);
  const Affine t{{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}, {0x1p20, 3, -4}};
  EXPECT_EQ(n.transform(t).point({1, 2, 3}), n.point(t.point({1, 2, 3})));
}

TEST(Vector, MirrorDirectionKeepsLengthAndTurnsTheNormalPart) {
  Trials trials(4);
  for (int i = 0; i < 1000; ++i) {
    const Vec3d d = trials.vector(1), n = trials.direction(), r = reflect(d, n);
    EXPECT_NEAR(length(r), length(d), 1e-14);
    EXPECT_NEAR(dot(r, n), -dot(d, n), 1e-14);
    expect_near(cross(r, n), cross(d, n), 1e-14);
  }
  EXPECT_EQ(normalize(Vec3d{}), Vec3d{});
}

}  // namespace
}  // namespace penumbra
