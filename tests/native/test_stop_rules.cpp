// SPDX-License-Identifier: GPL-3.0-or-later
// The stop rules against literal one-by-one implementations written here, on random contributions. That
// rendering follows them with its packets of rays is shown in tests/python/test_stop_rules.py.
#include <gtest/gtest.h>

#include <vector>

#include "lighting/stop_rule.h"
#include "oracles.h"

namespace penumbra {
namespace {

using test::Trials;

const Vec3d kDiffuse{1.5, 1.2, 0.1}, kPhong{0.3, 0.0, 2.0};

/// What one stream's points contribute by lobe; zero where hidden. `share` of them is hidden, in runs as a
/// blocker's.
struct Contributions {
  std::vector<float> diffuse, phong;

  Contributions(Trials& trials, size_t count, double share) : diffuse(count), phong(count) {
    for (size_t i = 0; i < count; ++i) {
      if (trials.uniform(0, 1) < share) continue;
      diffuse[i] = float(trials.uniform(0.08, 0.12));
      phong[i] = float(trials.uniform(0, 0.05));
    }
  }
  Vec3d operator[](size_t i) const { return kDiffuse * double(diffuse[i]) + kPhong * double(phong[i]); }
  size_t size() const { return diffuse.size(); }
};

struct Outcome {
  size_t count = 0;
  Vec3d mean;
  bool satisfied = false;
};

/// Section 3.2 of the paper, literally: add one by one; every t, compare with the mean t points earlier.
Outcome paper_literally(const Contributions& values, uint32_t t, double eps) {
  Outcome o;
  Vec3d sum, before;
  for (size_t i = 0; i < values.size() && !o.satisfied; ++i) {
    sum += values[i];
    o.mean = sum / double(++o.count);
    if (o.count % t) continue;
    const Vec3d change = o.mean - before;
    o.satisfied =
        o.count >= 2 * t && std::abs(change.x) < eps && std::abs(change.y) < eps && std::abs(change.z) < eps;
    before = o.mean;
  }
  return o;
}

/// sqrt(sample variance / n) < eps in each of r, g, b, from n = 10 on; two passes for every n.
Outcome variance_literally(const Contributions& values, double eps) {
  Outcome o;
  Vec3d sum;
  for (size_t i = 0; i < values.size() && !o.satisfied; ++i) {
    sum += values[i];
    const auto n = double(++o.count);
    o.mean = sum / n;
    if (o.count < 10) continue;
    Vec3d squares;
    for (size_t k = 0; k < o.count; ++k) squares += (values[k] - o.mean) * (values[k] - o.mean);
    const Vec3d v = squares / (n - 1) / n;
    o.satisfied = std::sqrt(v.x) < eps && std::sqrt(v.y) < eps && std::sqrt(v.z) < eps;
  }
  return o;
}

/// The rule's own protocol: asked after every next_check() points, which may end in the middle of a packet.
Outcome follow(const StopSettings& settings, const Contributions& values) {
  StopRule rule(settings, kDiffuse, kPhong);
  Moments moments;
  Outcome o;
  uint32_t until_check = rule.next_check(0);
  while (o.count < values.size() && !o.satisfied) {
    const size_t packet_end = std::min((o.count / kPacket + 1) * kPacket, values.size());
    const auto n = std::min(until_check, uint32_t(packet_end - o.count));
    moments.add(&values.diffuse[o.count], &values.phong[o.count], n);
    o.count += n;
    until_check -= n;
    if (until_check > 0) continue;
    o.satisfied = rule.enough(moments);
    until_check = rule.next_check(uint32_t(o.count));
  }
  o.mean = moments.mean(kDiffuse, kPhong);
  return o;
}

/// Counts are equal. Means are the same additions, by lobe first and then coloured: 1e-13 relative.
void expect_same(const Outcome& a, const Outcome& b) {
  EXPECT_EQ(a.count, b.count);
  EXPECT_EQ(a.satisfied, b.satisfied);
  EXPECT_LE(max_abs(a.mean - b.mean), 1e-13 * max_abs(b.mean));
}

TEST(StopRules, PaperStopsWhereTheLiteralRuleDoes) {
  Trials trials(1);
  size_t inside_packets = 0, never = 0;
  for (uint32_t t : {1u, 2u, 5u, 7u, 16u, 40u})
    for (double eps : {0.02, 0.004, 0.0005})
      for (int trial = 0; trial < 100; ++trial) {
        const Contributions values(trials, 500, trials.uniform(-0.3, 1));
        const Outcome expected = paper_literally(values, t, eps);
        SCOPED_TRACE(testing::Message() << "t " << t << ", eps " << eps << ", trial " << trial);
        expect_same(follow({StopRuleKind::kPaper, 64, 500, t, eps}, values), expected);
        inside_packets += expected.count % kPacket != 0;
        never += !expected.satisfied;
      }
  EXPECT_GT(inside_packets, 500u);
  EXPECT_GT(never, 5u);
}

TEST(StopRules, PaperComparesFirstAtTwiceTheInterval) {
  Trials trials(2);
  const Contributions values(trials, 500, 0.5);
  for (uint32_t t : {1u, 5u, 16u, 33u})  // a tolerance that everything meets
    EXPECT_EQ(follow({StopRuleKind::kPaper, 64, 500, t, 1e9}, values).count, 2 * t);
}

TEST(StopRules, PaperLooksAtEachColour) {
  // Only blue of the Phong lobe still changes: the rule must not stop.
  Trials trials(3);
  Contributions values(trials, 40, 0);
  for (size_t i = 0; i < values.size(); ++i) {
    values.diffuse[i] = 0.1f;
    values.phong[i] = i % 10 < 5 ? 0.0f : 0.01f;
  }
  // Means of phong at 5, 10, 15, ...: 0, 1/2, 1/3, 1/2, 2/5, ... x 0.01; in blue x 2: changes of 0.01,
  // 0.0033, ...
  EXPECT_EQ(follow({StopRuleKind::kPaper, 64, 40, 5, 0.003}, values).count,
            paper_literally(values, 5, 0.003).count);
  EXPECT_GT(follow({StopRuleKind::kPaper, 64, 40, 5, 0.003}, values).count, 15u);
}

TEST(StopRules, VarianceStopsWhereTheLiteralRuleDoes) {
  Trials trials(4);
  size_t later = 0;
  for (double eps : {0.05, 0.02, 0.005})
    for (int trial = 0; trial < 100; ++trial) {
      const Contributions values(trials, 700, trials.uniform(-0.3, 1));
      const Outcome expected = variance_literally(values, eps);
      SCOPED_TRACE(testing::Message() << "eps " << eps << ", trial " << trial);
      expect_same(follow({StopRuleKind::kVariance, 64, 700, 5, eps}, values), expected);
      EXPECT_GE(expected.count, 10u);
      later += expected.count > 10;
    }
  EXPECT_GT(later, 100u);
}

TEST(StopRules, VarianceWaitsForTenPoints) {
  // Equal contributions have no variance at all from the second on.
  Trials trials(5);
  Contributions values(trials, 50, 0);
  std::fill(values.diffuse.begin(), values.diffuse.end(), 0.25f);
  std::fill(values.phong.begin(), values.phong.end(), 0.0f);
  EXPECT_EQ(follow({StopRuleKind::kVariance, 64, 50, 5, 1e-6}, values).count, 10u);
}

TEST(StopRules, FixedAsksForItsNumber) {
  Trials trials(6);
  for (uint32_t n : {1u, 16u, 37u, 64u}) {
    const Contributions values(trials, n, 0.5);
    const Outcome o = follow({StopRuleKind::kFixed, n, 8192, 5, 1e-9}, values);
    EXPECT_EQ(o.count, n);
    EXPECT_TRUE(o.satisfied);
  }
}

}  // namespace
}  // namespace penumbra
