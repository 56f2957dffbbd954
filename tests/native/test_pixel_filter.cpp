// SPDX-License-Identifier: GPL-3.0-or-later
// The filter's importance sampling against its own definition, integrated numerically here.
#include <gtest/gtest.h>

#include <cmath>

#include "oracles.h"
#include "render/pixel_filter.h"

namespace penumbra {
namespace {

/// Blackman-Harris window of four terms (F. J. Harris 1978), x in [-1/2, 1/2] over its support.
double window(double x) {
  const double a = 2 * test::kPi * (x + 0.5);
  return 0.35875 - 0.48829 * std::cos(a) + 0.14128 * std::cos(2 * a) - 0.01168 * std::cos(3 * a);
}

double offset(const PixelFilter& filter, double x) {
  const auto variate = float(x);
  double out;
  filter.offsets(&variate, 1, &out);
  return out;
}

TEST(PixelFilter, OffsetsAreDistributedAsBlackmanHarris) {
  // x must be the filter's share to the left of offset(x). Composite midpoint rule with 2^16 steps: below
  // 1e-9; the engine's table makes the filter a histogram of 1024 steps: its cumulative is off by h^2/8
  // max|w'| = 1e-6 at most.
  constexpr int kSteps = 1 << 16;
  for (double width : {0.5, 1.5, 4.0}) {
    const PixelFilter filter(FilterKind::kBlackmanHarris, width);
    double total = 0;
    for (int i = 0; i < kSteps; ++i) total += window((i + 0.5) / kSteps - 0.5);
    double sum = 0;
    int step = 0;
    for (int k = 0; k <= 1024; ++k) {
      const double x = k == 1024 ? 1 - 0x1p-24 : k / 1024.0;                  // single precision
      const double place = (offset(filter, x) / (2 * width) + 0.5) * kSteps;  // in steps
      while (step < int(place)) sum += window((step++ + 0.5) / kSteps - 0.5);
      const double within = (place - step) * window((step + 0.5) / kSteps - 0.5);
      EXPECT_NEAR((sum + within) / total, x, 2e-6) << "width " << width;
    }
  }
}

TEST(PixelFilter, KnowsItsMeanDistanceAndTails) {
  // By the midpoint rule; reach_of's table has steps of 3e-6 at the most, and its end is never too near.
  constexpr int kSteps = 1 << 16;
  for (double width : {0.5, 1.5}) {
    double total = 0, distance = 0;
    for (int i = 0; i < kSteps; ++i) {
      const double x = (i + 0.5) / kSteps - 0.5;
      total += window(x);
      distance += window(x) * std::abs(x) * 2 * width;
    }
    const PixelFilter filter(FilterKind::kBlackmanHarris, width);
    EXPECT_NEAR(filter.mean_distance(), distance / total, 1e-5 * width);
    for (double share : {1e-5, 1e-4, 0.002, 0.05, 0.5}) {
      const double reach = filter.reach_of(share);
      double tail = 0;
      for (int i = 0; i < kSteps; ++i) {
        const double x = (i + 0.5) / kSteps - 0.5;
        if (x * 2 * width > reach) tail += window(x) / total;
      }
      EXPECT_LE(tail, share + 3e-5);
      EXPECT_GE(tail, 0.98 * share - 3e-5);
    }
  }
  const PixelFilter box(FilterKind::kBox, 2);
  EXPECT_EQ(box.mean_distance(), 0.5);
  EXPECT_EQ(box.reach_of(0.1), 0.8);
}

TEST(PixelFilter, StaysInItsSupportAndGrows) {
  for (FilterKind kind : {FilterKind::kBox, FilterKind::kBlackmanHarris})
    for (double width : {1e-3, 1.0, 1.5, 10.0}) {
      const PixelFilter filter(kind, width);
      EXPECT_EQ(filter.support(), kind == FilterKind::kBox ? width : 2 * width);
      double before = -width;
      for (int i = 0; i <= 4096; ++i) {
        const double x = i == 4096 ? 1 - 0x1p-24 : i / 4096.0, place = offset(filter, x);
        EXPECT_GE(place, -filter.support() / 2);
        EXPECT_LE(place, filter.support() / 2);
        EXPECT_GE(place, before);
        before = place;
      }
    }
}

TEST(PixelFilter, HasMeanZeroAndItsVariance) {
  // Midpoints of 2^14 equal shares of probability, so the mean is 0 by symmetry; variance of the window by
  // the midpoint rule. Tolerance: 1e-5 of the width squared, for the table's steps and the thin tails.
  for (double width : {1.0, 1.5}) {
    double weight = 0, square = 0;
    for (int i = 0; i < 4096; ++i) {
      const double x = (i + 0.5) / 4096 - 0.5;
      weight += window(x);
      square += window(x) * x * x;
    }
    const double variances[2] = {width * width / 12, square / weight * 4 * width * width};
    for (FilterKind kind : {FilterKind::kBox, FilterKind::kBlackmanHarris}) {
      const PixelFilter filter(kind, width);
      double mean = 0, variance = 0;
      for (int i = 0; i < 16384; ++i) {
        const double place = offset(filter, (i + 0.5) / 16384);
        mean += place / 16384;
        variance += place * place / 16384;
      }
      EXPECT_NEAR(mean, 0, 1e-12);
      EXPECT_NEAR(filter.variance(), variance, 1e-5 * width * width);
      EXPECT_NEAR(variance, variances[kind == FilterKind::kBox ? 0 : 1], 1e-5 * width * width);
    }
  }
}

}  // namespace
}  // namespace penumbra
