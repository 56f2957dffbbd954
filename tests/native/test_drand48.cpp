// SPDX-License-Identifier: GPL-3.0-or-later
// Oracle: the C library's own srand48 and drand48. Everything is integer arithmetic: equality, no tolerance.
#include <gtest/gtest.h>
#include <stdlib.h>

#include "sampling/drand48.h"

namespace penumbra {
namespace {

TEST(Drand48, EqualsTheCLibrary) {
  for (uint32_t seed : {0u, 1u, 42u, 123456789u, 0x7FFFFFFFu, 0x80000000u, 0xFFFFFFFFu}) {
    srand48(long(seed));
    Drand48 random(seed);
    for (int i = 0; i < 1000; ++i)
      ASSERT_EQ(double(random.next_bits()) * 0x1p-48, drand48()) << "seed " << seed << ", value " << i;
  }
}

TEST(Drand48, JumpEqualsThatManySteps) {
  for (uint64_t n : {0, 1, 2, 3, 7, 64, 1000, 65537}) {
    Drand48 stepped(7), jumped(7);
    for (uint64_t i = 0; i < n; ++i) stepped.next_bits();
    jumped.jump(n);
    EXPECT_EQ(jumped.next_bits(), stepped.next_bits()) << n << " steps";
  }
}

TEST(Drand48, JumpsAddUp) {
  const uint64_t far = uint64_t(1) << 40;
  for (uint64_t a : {uint64_t(0), uint64_t(12345), far, far + 987654321}) {
    for (uint64_t b : {uint64_t(1), uint64_t(99991), far - 1, 3 * far}) {
      Drand48 twice(3), once(3);
      twice.jump(a);
      twice.jump(b);
      once.jump(a + b);
      EXPECT_EQ(twice.next_bits(), once.next_bits()) << a << " + " << b;
    }
  }
}

TEST(Drand48, HasPeriodTwoToThe48) {
  // Full period: c is odd and a - 1 a multiple of 4 (Hull and Dobell 1962).
  const uint64_t period = uint64_t(1) << 48;
  Drand48 start(11), round(11), half(11);
  round.jump(period);
  half.jump(period / 2);
  const uint64_t first = start.next_bits();
  EXPECT_EQ(round.next_bits(), first);
  EXPECT_NE(half.next_bits(), first);
}

}  // namespace
}  // namespace penumbra
