// SPDX-License-Identifier: GPL-3.0-or-later
// Running sums against a long double reference that is given the same floats.
#include <gtest/gtest.h>

#include <vector>

#include "lighting/moments.h"
#include "oracles.h"

namespace penumbra {
namespace {

using test::Trials;

struct Reference {
  long double mean[3], variance_of_mean[3];
};

/// Two passes in long double: means first, then deviations.
Reference reference(const std::vector<float>& f, const std::vector<float>& p, const Vec3d& d,
                    const Vec3d& s) {
  Reference r{};
  const auto n = static_cast<long double>(f.size());
  for (int c = 0; c < 3; ++c) {
    const auto value = [&](size_t i) {
      return static_cast<long double>(d[c]) * f[i] + static_cast<long double>(s[c]) * (p.empty() ? 0 : p[i]);
    };
    for (size_t i = 0; i < f.size(); ++i) r.mean[c] += value(i) / n;
    long double squares = 0;
    for (size_t i = 0; i < f.size(); ++i) squares += (value(i) - r.mean[c]) * (value(i) - r.mean[c]);
    r.variance_of_mean[c] = squares / (n - 1) / n;
  }
  return r;
}

std::vector<float> contributions(Trials& trials, size_t count, double share_hidden) {
  std::vector<float> values(count);
  for (float& v : values) v = trials.uniform(0, 1) < share_hidden ? 0.0f : float(trials.uniform(0.1, 0.3));
  return values;
}

Moments add_in_spans(const std::vector<float>& f, const std::vector<float>& p, uint32_t span) {
  Moments m;
  for (uint32_t first = 0; first < f.size(); first += span)
    m.add(&f[first], p.empty() ? nullptr : &p[first], std::min(span, uint32_t(f.size()) - first));
  return m;
}

TEST(Moments, MeanAndVarianceEqualTheReference) {
  // n additions of doubles: n 2^-53 relative for the mean, 1e-12 is generous at n = 5000. The variance is the
  // difference of two sums about 1 / (1 - hidden) ... 30 times as large: 1e-10.
  Trials trials(1);
  const Vec3d diffuse{1.0, 0.5, 0.01}, phong{0.2, 0.0, 3.0};
  for (uint32_t count : {2u, 10u, 16u, 333u, 5000u})
    for (double hidden : {0.0, 0.3, 0.9})
      for (bool with_phong : {false, true}) {
        const auto f = contributions(trials, count, hidden);
        const auto p = with_phong ? contributions(trials, count, hidden) : std::vector<float>{};
        const Reference r = reference(f, p, diffuse, phong);
        for (uint32_t span : {1u, 5u, 16u, 64u}) {
          const Moments m = add_in_spans(f, p, span);
          const Vec3d mean = m.mean(diffuse, phong), variance = m.variance_of_mean(diffuse, phong);
          ASSERT_EQ(m.count, count);
          for (int c = 0; c < 3; ++c) {
            EXPECT_NEAR(mean[c], double(r.mean[c]), 1e-12 * double(r.mean[c]))
                << count << " in spans of " << span;
            EXPECT_NEAR(variance[c], double(r.variance_of_mean[c]),
                        1e-10 * double(r.variance_of_mean[c]) + 1e-18);
          }
        }
      }
}

TEST(Moments, SpansShorterThanAPacketAreSummedOneByOne) {
  // The paper's rule compares running means: those of one-by-one addition, bit for bit.
  Trials trials(2);
  const auto f = contributions(trials, 1000, 0.4);
  double sum = 0;
  for (float v : f) sum += double(v);
  for (uint32_t span : {1u, 2u, 5u, 15u}) EXPECT_EQ(add_in_spans(f, {}, span).f, sum);
}

TEST(Moments, EqualContributionsHaveNoVariance) {
  // Rounding may leave the difference of the sums on either side of zero; the variance must not be negative.
  for (float value : {0.0f, 0.1f, 1e-20f, 3e20f}) {
    const std::vector<float> f(777, value);
    const Moments m = add_in_spans(f, {}, 5);
    const Vec3d v = m.variance_of_mean({1, 1, 1}, {});
    EXPECT_GE(v.x, 0);
    EXPECT_LE(v.x, 1e-14 * double(value) * double(value));
  }
}

TEST(Moments, OnePointHasNoVarianceYet) {
  Moments m;
  const float f = 0.5f;
  m.add(&f, nullptr, 1);
  EXPECT_EQ(m.variance_of_mean({1, 1, 1}, {}), Vec3d{});
  EXPECT_EQ(m.mean({1, 2, 4}, {}), (Vec3d{0.5, 1, 2}));
}

}  // namespace
}  // namespace penumbra
