// SPDX-License-Identifier: GPL-3.0-or-later
// Every sampler with every treatment from pixel to pixel, through the interface that rendering uses.
#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <cmath>

#include "points.h"
#include "sampling/sampler.h"
#include "sampling/sequences.h"

namespace penumbra {
namespace {

using test::all_kinds;
using test::all_reuses;
using test::fixed32;
using test::name_of;
using test::Points;
using test::points_of;

constexpr uint32_t kStreams[] = {0, 1, 2, 77, 4096, 123456};

bool is_random(SamplerKind kind) {
  return kind == SamplerKind::kPrs || kind == SamplerKind::kSprs;
}

template <typename Check>
void for_each_combination(Check check) {
  for (SamplerKind kind : all_kinds())
    for (SampleReuse reuse : all_reuses()) {
      SCOPED_TRACE(name_of(kind, reuse));
      check(kind, reuse);
    }
}

bool same(const Points& a, const Points& b) {
  return a.u == b.u && a.v == b.v;
}

TEST(Samplers, PointsAre24BitFractionsBelowOne) {
  for_each_combination([](SamplerKind kind, SampleReuse reuse) {
    for (uint32_t seed : {0u, 1u, 0xFFFFFFFFu}) {
      const auto sampler = make_sampler({kind, reuse, seed, 4096});
      for (uint32_t stream : kStreams) {
        const Points p = points_of(*sampler, stream, 4096);
        for (const auto* axis : {&p.u, &p.v})
          for (float x : *axis) {
            ASSERT_GE(x, 0.0f);
            ASSERT_LE(x, 1.0f - 0x1p-24f);
            ASSERT_EQ(x * 0x1p24f, std::floor(x * 0x1p24f)) << "no multiple of 2^-24: " << x;
          }
      }
    }
  });
}

TEST(Samplers, PacketsAndLongRunsAgree) {
  for_each_combination([](SamplerKind kind, SampleReuse reuse) {
    for (const std::vector<uint32_t>& levels : {std::vector<uint32_t>{}, {0, 400}, {16, 32, 48, 300}}) {
      const auto sampler = make_sampler({kind, reuse, 3, 400, levels});
      const Points all = points_of(*sampler, 9, 400);
      for (uint32_t first = 0; first < 400; first += kPacket) {
        float u[kPacket], v[kPacket];
        sampler->points(test::key_of(9), first, kPacket, u, v);
        ASSERT_TRUE(std::equal(u, u + kPacket, all.u.begin() + first));
        ASSERT_TRUE(std::equal(v, v + kPacket, all.v.begin() + first));
      }
    }
  });
}

TEST(Samplers, FirstPointsOfManyStreamsAreThoseOfEach) {
  for_each_combination([](SamplerKind kind, SampleReuse reuse) {
    const auto sampler = make_sampler({kind, reuse, 3, 400});
    constexpr uint32_t kCount = 4, kMany = 21;
    std::vector<StreamKey> keys;
    for (uint32_t i = 0; i < kMany; ++i) keys.push_back(test::key_of(7 * i));
    float u[kCount * kMany], v[kCount * kMany];
    sampler->first_points(keys, kCount, u, v);
    for (uint32_t i = 0; i < kMany; ++i) {
      const Points own = points_of(*sampler, 7 * i, kCount);
      for (uint32_t k = 0; k < kCount; ++k) {
        ASSERT_EQ(u[k * kMany + i], own.u[k]);
        ASSERT_EQ(v[k * kMany + i], own.v[k]);
      }
    }
  });
}

TEST(Samplers, SameIsTheSameEverywhereAndTheOthersDiffer) {
  for_each_combination([](SamplerKind kind, SampleReuse reuse) {
    const auto sampler = make_sampler({kind, reuse, 5, 64});
    const bool expected = reuse == SampleReuse::kSame && !is_random(kind);
    const Points first = points_of(*sampler, 0, 64);
    for (uint32_t stream : {1u, 2u, 500u}) EXPECT_EQ(same(points_of(*sampler, stream, 64), first), expected);
  });
}

TEST(Samplers, ContinuedGoesOnWhereThePixelBeforeEnded) {
  // Pixel k of a sampler with 64 points a pixel has points 64 k ... 64 k + 63 of one long stream.
  for (SamplerKind kind : all_kinds()) {
    if (kind == SamplerKind::kSprs) continue;  // its grid starts anew
    const auto pixels = make_sampler({kind, SampleReuse::kContinued, 9, 64});
    const auto one_stream = make_sampler({kind, SampleReuse::kContinued, 9, 4096});
    const Points all = points_of(*one_stream, 0, 4096);
    for (uint32_t k = 0; k < 64; ++k) {
      const Points p = points_of(*pixels, k, 64);
      ASSERT_TRUE(std::equal(p.u.begin(), p.u.end(), all.u.begin() + 64 * k))
          << name_of(kind, SampleReuse::kContinued);
      ASSERT_TRUE(std::equal(p.v.begin(), p.v.end(), all.v.begin() + 64 * k))
          << name_of(kind, SampleReuse::kContinued);
    }
  }
}

TEST(Samplers, UnscrambledSequencesAreTheSequencesThemselves) {
  // Truncated to 24 bits; Sobol' of the book and Halton start at index 1 + seed.
  for (uint32_t seed : {0u, 10u}) {
    const auto sobol = make_sampler({SamplerKind::kSobol, SampleReuse::kSame, seed, 500});
    const auto halton = make_sampler({SamplerKind::kHalton, SampleReuse::kSame, seed, 500});
    const Points s = points_of(*sobol, 3, 500), h = points_of(*halton, 3, 500);
    for (uint32_t i = 0; i < 500; ++i) {
      const FixedPoint2 a = digital_point(kNumericalRecipesSobol, 1 + seed + i),
                        b = halton_point(1 + seed + i);
      ASSERT_EQ(fixed32(s.u[i]), a.u & ~0xFFu);
      ASSERT_EQ(fixed32(s.v[i]), a.v & ~0xFFu);
      ASSERT_EQ(fixed32(h.u[i]), b.u & ~0xFFu);
      ASSERT_EQ(fixed32(h.v[i]), b.v & ~0xFFu);
    }
  }
}

TEST(Samplers, RotatedIsSameShiftedModuloOne) {
  // Both are truncated to 24 bits after the shift: the differences agree within one unit of 2^-24.
  for (SamplerKind kind : {SamplerKind::kSobol, SamplerKind::kHalton, SamplerKind::kOwenSobol}) {
    SCOPED_TRACE(name_of(kind, SampleReuse::kRotated));
    const auto plain = make_sampler({kind, SampleReuse::kSame, 4, 256});
    const auto rotated = make_sampler({kind, SampleReuse::kRotated, 4, 256});
    for (uint32_t stream : kStreams) {
      const Points a = points_of(*plain, stream, 256), b = points_of(*rotated, stream, 256);
      const auto shift = [](float from, float to) { return uint32_t(fixed32(to) - fixed32(from)) >> 8; };
      const uint32_t shift_u = shift(a.u[0], b.u[0]), shift_v = shift(a.v[0], b.v[0]);
      const auto off = [](uint32_t x, uint32_t y) {
        return std::min((x - y) & 0xFFFFFFu, (y - x) & 0xFFFFFFu);
      };
      for (uint32_t i = 0; i < 256; ++i) {
        ASSERT_LE(off(shift(a.u[i], b.u[i]), shift_u), 1u);
        ASSERT_LE(off(shift(a.v[i], b.v[i]), shift_v), 1u);
      }
    }
  }
}

TEST(Samplers, PrsIsTheCLibrarysSequence) {
  // Stream k starts at pair k N; every value is drand48() rounded down to 24 bits.
  constexpr uint32_t kCount = 48;
  const auto sampler = make_sampler({SamplerKind::kPrs, SampleReuse::kSame, 1234, kCount});
  srand48(1234);
  const auto next = [] { return float(std::floor(drand48() * 0x1p24) * 0x1p-24); };
  for (uint32_t stream = 0; stream < 40; ++stream) {
    const Points p = points_of(*sampler, stream, kCount);
    for (uint32_t i = 0; i < kCount; ++i) {
      ASSERT_EQ(p.u[i], next()) << "stream " << stream << ", point " << i;
      ASSERT_EQ(p.v[i], next()) << "stream " << stream << ", point " << i;
    }
  }
}

TEST(Samplers, LevelsChangeTheOrderBetweenThemOnly) {
  const auto first_points = [](const Points& p, size_t count) {
    std::vector<std::pair<float, float>> pairs;
    for (size_t i = 0; i < count; ++i) pairs.emplace_back(p.u[i], p.v[i]);
    return pairs;
  };
  for_each_combination([&](SamplerKind kind, SampleReuse reuse) {
    std::vector<std::vector<uint32_t>> cases{{16, 32, 48, 64, 96, 128, 192, 256, 384}};
    for (uint32_t count : {1u, 16u, 49u, 64u, 400u}) cases.push_back({0, count});
    for (const std::vector<uint32_t>& levels : cases) {
      const uint32_t count = kind == SamplerKind::kSprs ? 400 : levels.back();
      const Points a = points_of(*make_sampler({kind, reuse, 8, count}), 21, count);
      const Points b = points_of(*make_sampler({kind, reuse, 8, count, levels}), 21, count);
      EXPECT_EQ(first_points(a, levels.front()), first_points(b, levels.front())) << "in order up to there";
      for (uint32_t level : levels) {
        auto expected = first_points(a, level), found = first_points(b, level);
        std::sort(expected.begin(), expected.end());
        std::sort(found.begin(), found.end());
        EXPECT_EQ(expected, found) << level << " points";
      }
    }
  });
}

/// What levels are for: 64 points of a (0,2)-sequence make four packets, each in a quarter of the square.
TEST(Samplers, LevelsKeepPacketsTogether) {
  const auto sampler =
      make_sampler({SamplerKind::kOwenSobol, SampleReuse::kScrambled, 8, 256, {0, 64, 128, 192, 256}});
  for (uint32_t stream = 0; stream < 10; ++stream) {
    const Points p = points_of(*sampler, stream, 256);
    for (uint32_t i = 0; i < 256; ++i) {
      const uint32_t packet = i / kPacket * kPacket;
      ASSERT_EQ(p.u[i] < 0.5f, p.u[packet] < 0.5f) << "point " << i;
      ASSERT_EQ(p.v[i] < 0.5f, p.v[packet] < 0.5f) << "point " << i;
    }
  }
}

TEST(Samplers, SprsPutsOnePointIntoEachCell) {
  // 2^18 points on each of several grids, with jitter below 1 by less than a float's last place among them:
  // rounding must not carry any point out of its cell. Cells are half open, [c / side, (c + 1) / side).
  for (uint32_t side : {1u, 2u, 3u, 7u, 8u, 10u, 64u, 100u}) {
    const uint32_t count = side * side, streams = std::max(1u, (1u << 18) / count);
    const auto sampler = make_sampler({SamplerKind::kSprs, SampleReuse::kScrambled, side, count, {0, count}});
    for (uint32_t stream = 0; stream < streams; ++stream) {
      const Points p = points_of(*sampler, stream, count);
      for (uint32_t i = 0; i < count; ++i) {
        // Exact: 24-bit fraction x at most 7 bits.
        ASSERT_EQ(uint32_t(std::floor(double(p.u[i]) * side)), i % side) << "side " << side << ", " << p.u[i];
        ASSERT_EQ(uint32_t(std::floor(double(p.v[i]) * side)), i / side) << "side " << side << ", " << p.v[i];
      }
    }
  }
}

TEST(Samplers, RefuseWhatTheyCannotDo) {
  EXPECT_THROW(make_sampler({SamplerKind::kSprs, SampleReuse::kSame, 0, 63}), std::invalid_argument);
  for (SamplerKind kind : all_kinds())
    EXPECT_THROW(make_sampler({kind, SampleReuse::kSame, 0, 0}), std::invalid_argument);
}

}  // namespace
}  // namespace penumbra
