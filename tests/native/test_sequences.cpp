// SPDX-License-Identifier: GPL-3.0-or-later
// The sequences against published values and against what defines them: exact counts in elementary
// intervals. Everything is exact, so there are no tolerances.
#include <gtest/gtest.h>

#include "points.h"
#include "sampling/sequences.h"

namespace penumbra {
namespace {

using test::all_equal;
using test::count_cells;

FixedPoint2 fraction(uint64_t u, uint64_t du, uint64_t v, uint64_t dv) {
  return {uint32_t((u << 32) / du), uint32_t((v << 32) / dv)};
}

void expect_point(const FixedPoint2& p, const FixedPoint2& expected, uint64_t index) {
  EXPECT_EQ(p.u, expected.u) << "index " << index;
  EXPECT_EQ(p.v, expected.v) << "index " << index;
}

TEST(Sobol, StartsAsPublished) {
  // What IDL's manual prints for SOBOLSEQUENCE(2, 4), "based on the routine sobseq described in section 7.7
  // of Numerical Recipes": (0.5, 0.5), (0.25, 0.75), (0.75, 0.25), (0.375, 0.625).
  const double published[4][2] = {{0.5, 0.5}, {0.25, 0.75}, {0.75, 0.25}, {0.375, 0.625}};
  for (uint32_t i = 0; i < 4; ++i) {
    const FixedPoint2 p = digital_point(kNumericalRecipesSobol, i + 1);
    EXPECT_EQ(p.u * 0x1p-32, published[i][0]);
    EXPECT_EQ(p.v * 0x1p-32, published[i][1]);
  }
}

TEST(Sobol, First16PointsFollowTheBooksRecurrence) {
  // By hand from section 7.7: the integers m of the first dimension are 1, 3, 5, 15, 17 (polynomial x + 1:
  // m_i = 2 m_(i-1) ^ m_(i-1)), of the second 1, 1, 7, 11, 13 (x^2 + x + 1: m_i = 2 m_(i-1) ^ 4 m_(i-2) ^
  // m_(i-2)); the book's table of initial values has the first four of each. Direction number i is m_i / 2^i,
  // and point n is point n - 1 with direction number (place of the lowest zero of n - 1) exclusive-ored in.
  // In units of 1/32:
  const int expected[16][2] = {{16, 16}, {8, 24}, {24, 8}, {12, 20}, {28, 4},  {4, 12}, {20, 28}, {10, 10},
                               {26, 26}, {2, 18}, {18, 2}, {6, 30},  {22, 14}, {14, 6}, {30, 22}, {15, 27}};
  const int m[2][5] = {{1, 3, 5, 15, 17}, {1, 1, 7, 11, 13}};
  int u = 0, v = 0;
  for (uint32_t n = 1; n <= 16; ++n) {
    int zero = 0;
    while ((n - 1) >> zero & 1) ++zero;
    u ^= m[0][zero] << (4 - zero);
    v ^= m[1][zero] << (4 - zero);
    ASSERT_EQ(u, expected[n - 1][0]) << "the recurrence and the list disagree at " << n;
    ASSERT_EQ(v, expected[n - 1][1]) << "the recurrence and the list disagree at " << n;
    expect_point(digital_point(kNumericalRecipesSobol, n), fraction(u, 32, v, 32), n);
  }
}

TEST(Sobol, DirectionNumbersFollowTheRecurrenceToTheLastBit) {
  std::array<uint64_t, 32> m1{1}, m2{1, 1};
  for (int i = 1; i < 32; ++i) m1[i] = 2 * m1[i - 1] ^ m1[i - 1];
  for (int i = 2; i < 32; ++i) m2[i] = 2 * m2[i - 1] ^ 4 * m2[i - 2] ^ m2[i - 2];
  for (int i = 0; i < 32; ++i) {
    EXPECT_EQ(kNumericalRecipesSobol.u[i], m1[i] << (31 - i));
    EXPECT_EQ(kNumericalRecipesSobol.v[i], m2[i] << (31 - i));
    EXPECT_EQ(kZeroTwoSobol.u[i], 0x80000000u >> i);  // van der Corput
    EXPECT_EQ(kZeroTwoSobol.v[i], m1[i] << (31 - i));
  }
}

TEST(Sobol, NextPointEqualsPoint) {
  for (const DigitalMatrices* matrices : {&kNumericalRecipesSobol, &kZeroTwoSobol}) {
    for (uint32_t start : {0u, 1000000u, 0xFFFFFF00u}) {  // the last one passes the end of the sequence
      FixedPoint2 p = digital_point(*matrices, start);
      for (uint32_t i = start + 1; i != start + 512; ++i) {
        p = next_digital_point(*matrices, p, i);
        expect_point(p, digital_point(*matrices, i), i);
      }
    }
  }
}

/// Over blocks [j 2^k, (j+1) 2^k): does every elementary interval of volume 2^(t-k) hold 2^t points?
bool is_t2_sequence(const DigitalMatrices& matrices, int t, int largest_k, uint32_t blocks) {
  const auto u = [&](size_t i) { return digital_point(matrices, uint32_t(i)).u; };
  const auto v = [&](size_t i) { return digital_point(matrices, uint32_t(i)).v; };
  for (int k = t; k <= largest_k; ++k)
    for (uint32_t j : {0u, 1u, 2u, 3u, 5u, blocks})
      for (int a = 0; a <= k - t; ++a)
        if (!all_equal(count_cells(size_t(j) << k, size_t(1) << k, uint64_t(1) << a,
                                   uint64_t(1) << (k - t - a), u, v),
                       1u << t))
          return false;
  return true;
}

TEST(Sobol, OfTheBookIsAOneTwoSequenceAndNoBetter) {
  EXPECT_TRUE(is_t2_sequence(kNumericalRecipesSobol, 1, 12, 1000));
  EXPECT_FALSE(is_t2_sequence(kNumericalRecipesSobol, 0, 12, 1000));
  // By the list above: of the first eight points, origin included, (0, 0) and (1/8, 3/8) share the cell
  // [0, 1/4) x [0, 1/2).
  const auto u = [](size_t i) { return digital_point(kNumericalRecipesSobol, uint32_t(i)).u; };
  const auto v = [](size_t i) { return digital_point(kNumericalRecipesSobol, uint32_t(i)).v; };
  EXPECT_EQ(count_cells(0, 8, 4, 2, u, v)[0], 2u);
}

TEST(Sobol, ZeroTwoIsAZeroTwoSequence) {
  EXPECT_TRUE(is_t2_sequence(kZeroTwoSobol, 0, 12, 1000));
}

TEST(OwenScrambling, EachDigitDependsOnTheDigitsBeforeItAlone) {
  for (uint32_t seed : {0u, 1u, 0x9E3779B9u, 0xFFFFFFFFu}) {
    for (uint32_t x : {0u, 0x12345678u, 0xDEADBEEFu, 0xFFFFFFFFu}) {
      for (int digit = 0; digit < 32; ++digit) {
        const uint32_t changed =
            owen_scramble_reversed(x, seed) ^ owen_scramble_reversed(x ^ (1u << digit), seed);
        EXPECT_EQ(changed & ((1u << digit) - 1), 0u) << "earlier digits changed";
        EXPECT_EQ(changed >> digit & 1, 1u) << "the digit itself must stay a permutation";
      }
    }
  }
}

TEST(Halton, First16PointsAreTheExactFractions) {
  // Digits of 1 ... 16 in bases 2 and 3 mirrored at the point, as in any textbook.
  const int expected[16][4] = {{1, 2, 1, 3},     {1, 4, 2, 3},    {3, 4, 1, 9},     {1, 8, 4, 9},
                               {5, 8, 7, 9},     {3, 8, 2, 9},    {7, 8, 5, 9},     {1, 16, 8, 9},
                               {9, 16, 1, 27},   {5, 16, 10, 27}, {13, 16, 19, 27}, {3, 16, 4, 27},
                               {11, 16, 13, 27}, {7, 16, 22, 27}, {15, 16, 7, 27},  {1, 32, 16, 27}};
  for (uint32_t i = 0; i < 16; ++i) {
    const auto& e = expected[i];
    expect_point(halton_point(i + 1), fraction(e[0], e[1], e[2], e[3]), i + 1);
  }
}

/// Every elementary interval of 2^a x 3^b holds one point of each block of 2^a 3^b. The ternary coordinate is
/// rounded down, which takes a point on a cell's lower edge out of it: one unit of the last place brings it
/// back and moves no other, since points and edges are at least 3^-20 > 2^-32 apart.
template <typename Point>
void expect_halton_net(Point point, uint64_t largest_block) {
  for (uint64_t columns = 1; columns <= largest_block; columns *= 2) {
    for (uint64_t rows = 1; columns * rows <= largest_block; rows *= 3) {
      const uint64_t block = columns * rows;
      for (uint64_t j : {0, 1, 2, 5, 1000}) {
        std::vector<uint32_t> cells(block, 0);
        for (uint64_t i = j * block; i < (j + 1) * block; ++i) {
          const FixedPoint2 p = point(i);
          ++cells[(uint64_t(p.u) * columns >> 32) * rows + ((uint64_t(p.v) + 1) * rows >> 32)];
        }
        ASSERT_TRUE(all_equal(cells, 1)) << columns << " x " << rows << " cells, block " << j;
      }
    }
  }
}

TEST(Halton, EveryBlockFillsEveryElementaryInterval) {
  expect_halton_net([](uint64_t i) { return halton_point(i); }, 5000);
}

TEST(Halton, ScrambledBlocksFillEveryElementaryInterval) {
  for (uint64_t seed : {0u, 1u, 77u, 0xFFFFFFFFu})
    expect_halton_net([seed](uint64_t i) { return scrambled_halton_point(i, seed); }, 2500);
}

}  // namespace
}  // namespace penumbra
