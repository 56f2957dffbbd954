// SPDX-License-Identifier: GPL-3.0-or-later
// Randomised points: still nets after scrambling, different and uniform from pixel to pixel, and the same
// from the vectorised loops as from plain scalar arithmetic.
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "points.h"
#include "sampling/sequences.h"

namespace penumbra {
namespace {

using test::all_equal;
using test::count_cells;
using test::fixed32;
using test::Points;
using test::points_of;

/// Over aligned blocks of the stream: one point in every elementary interval of volume 2^-k, k <= 10.
void expect_zero_two_net(const Points& p) {
  const auto u = [&](size_t i) { return fixed32(p.u[i]); };
  const auto v = [&](size_t i) { return fixed32(p.v[i]); };
  for (int k = 0; k <= 10 && (size_t(1) << k) <= p.size(); ++k)
    for (size_t first = 0; first + (size_t(1) << k) <= p.size(); first += size_t(5) << k)
      for (int a = 0; a <= k; ++a)
        ASSERT_TRUE(all_equal(count_cells(first, size_t(1) << k, 1u << a, 1u << (k - a), u, v), 1))
            << "2^" << k << " points from " << first << ", 2^" << a << " columns";
}

TEST(Scrambling, OwenSobolIsAZeroTwoSequenceInEveryPixel) {
  for (SampleReuse reuse : {SampleReuse::kSame, SampleReuse::kContinued, SampleReuse::kScrambled})
    for (uint32_t seed : {0u, 1u, 0xFFFFFFFFu}) {
      const auto sampler = make_sampler({SamplerKind::kOwenSobol, reuse, seed, 4096});
      for (uint64_t stream : {0u, 1u, 12345u}) expect_zero_two_net(points_of(*sampler, stream, 4096));
    }
}

TEST(Scrambling, ScrambledSobolOfTheBookStaysAOneTwoSequence) {
  // The stream starts at index 1, so a block [j 2^k, (j + 1) 2^k) of indices starts at its point j 2^k - 1.
  const auto sampler = make_sampler({SamplerKind::kSobol, SampleReuse::kScrambled, 0, 4096});
  for (uint64_t stream : {0u, 1u, 12345u}) {
    const Points p = points_of(*sampler, stream, 4096);
    const auto u = [&](size_t i) { return fixed32(p.u[i]); };
    const auto v = [&](size_t i) { return fixed32(p.v[i]); };
    for (int k = 1; k <= 10; ++k)
      for (size_t j : {1, 2, 3})
        for (int a = 0; a < k; ++a)
          ASSERT_TRUE(
              all_equal(count_cells((j << k) - 1, size_t(1) << k, 1u << a, 1u << (k - 1 - a), u, v), 2));
  }
}

TEST(Scrambling, ScrambledHaltonBlocksStayEven) {
  // Indices 6^4 ... 2 6^4 - 1 and the next such block; the stream starts at index 1. Rounding down to 24 bits
  // can take a point across a ternary edge, with a chance of 81 / 2^25 a point (half a unit is added back): 1
  // % over all points of this test, whose keys are fixed.
  constexpr uint32_t kBlock = 1296;
  const auto sampler = make_sampler({SamplerKind::kHalton, SampleReuse::kScrambled, 0, 3 * kBlock});
  for (uint64_t stream : {0u, 1u, 12345u}) {
    const Points p = points_of(*sampler, stream, 3 * kBlock);
    const auto u = [&](size_t i) { return fixed32(p.u[i]); };
    const auto v = [&](size_t i) { return fixed32(p.v[i]) + 128; };
    for (uint32_t block : {1u, 2u})
      EXPECT_TRUE(all_equal(count_cells(block * kBlock - 1, kBlock, 16, 81, u, v), 1)) << "stream " << stream;
  }
}

TEST(Scrambling, PixelsDifferAndAreUniform) {
  // Point i of 65536 pixels in 16 x 16 cells. Chi-square with 255 degrees of freedom exceeds 377 with a
  // chance of 1e-6 if the points are independent and uniform (Wilson and Hilferty 1931); 3 samplers x 4
  // points are tested.
  for (SampleReuse reuse : {SampleReuse::kScrambled, SampleReuse::kRotated})
    for (SamplerKind kind : {SamplerKind::kSobol, SamplerKind::kHalton, SamplerKind::kOwenSobol}) {
      SCOPED_TRACE(test::name_of(kind, reuse));
      const auto sampler = make_sampler({kind, reuse, 0, 64});
      constexpr uint32_t kPixels = 65536;
      const uint32_t chosen[] = {0, 1, 15, 50};
      std::vector<uint32_t> counts[4];
      for (auto& c : counts) c.resize(256);
      std::set<std::pair<float, float>> first;
      for (uint32_t pixel = 0; pixel < kPixels; ++pixel) {
        const Points p = points_of(*sampler, pixel, 64);
        for (int k = 0; k < 4; ++k)
          ++counts[k][uint32_t(p.u[chosen[k]] * 16) * 16 + uint32_t(p.v[chosen[k]] * 16)];
        first.emplace(p.u[0], p.v[0]);
      }
      for (const auto& c : counts) {
        double chi_square = 0;
        for (uint32_t n : c) chi_square += (n - 256.0) * (n - 256.0) / 256.0;
        EXPECT_LT(chi_square, 377.0);
        EXPECT_GT(chi_square, 255 - 5 * std::sqrt(2 * 255.0)) << "too even to be random";
      }
      // Of 65536 random pairs in 2^48 places 7.6e-6 pairs are expected to be equal.
      EXPECT_EQ(first.size(), kPixels);
    }
}

TEST(Scrambling, TheLuminairesOfAPixelGetDifferentPoints) {
  // Consecutive streams are the luminaires of one pixel: their first points must not correlate. The
  // correlation of 20000 independent pairs has standard deviation 1/sqrt(20000) = 0.007; five of them: 6e-7.
  for (SamplerKind kind : {SamplerKind::kSobol, SamplerKind::kHalton, SamplerKind::kOwenSobol}) {
    const auto sampler = make_sampler({kind, SampleReuse::kScrambled, 0, 16});
    double sum = 0;
    for (uint32_t pixel = 0; pixel < 20000; ++pixel) {
      const Points a = points_of(*sampler, 2 * pixel, 16), b = points_of(*sampler, 2 * pixel + 1, 16);
      sum += (a.u[0] - 0.5) * (b.u[0] - 0.5) * 12;
    }
    EXPECT_LT(std::abs(sum / 20000), 5 * 0.00707) << test::name_of(kind, SampleReuse::kScrambled);
  }
}

TEST(Scrambling, VectorisedLoopsEqualScalarArithmetic) {
  // The functions with target_clones against the inline ones of hash.h, one point at a time, bit for bit.
  // What the sampler does with its key is documented at StreamKey and in sequence_sampler.cpp.
  constexpr uint32_t kCount = 333;
  for (uint32_t seed : {0u, 5u})
    for (uint64_t stream : {0u, 3u, 999u}) {
      const auto key = test::key_of(stream);
      const uint64_t bits = hash_of(seed, key.hash), frame = hash_of(seed, 0);
      const auto owen = [](uint32_t x, uint32_t s) {
        return reverse_bits(owen_scramble_reversed(reverse_bits(x), s));
      };
      const auto scrambled = points_of(
          *make_sampler({SamplerKind::kOwenSobol, SampleReuse::kScrambled, seed, kCount}), stream, kCount);
      const auto rotated = points_of(
          *make_sampler({SamplerKind::kOwenSobol, SampleReuse::kRotated, seed, kCount}), stream, kCount);
      for (uint32_t i = 0; i < kCount; ++i) {
        const FixedPoint2 p = digital_point(kZeroTwoSobol, i);
        ASSERT_EQ(fixed32(scrambled.u[i]), owen(p.u, uint32_t(bits)) & ~0xFFu);
        ASSERT_EQ(fixed32(scrambled.v[i]), owen(p.v, uint32_t(bits >> 32)) & ~0xFFu);
        ASSERT_EQ(fixed32(rotated.u[i]), (owen(p.u, uint32_t(frame)) + uint32_t(bits)) & ~0xFFu);
        ASSERT_EQ(fixed32(rotated.v[i]), (owen(p.v, uint32_t(frame >> 32)) + uint32_t(bits >> 32)) & ~0xFFu);
      }
    }
}

}  // namespace
}  // namespace penumbra
