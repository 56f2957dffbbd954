// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <memory>

#include "lighting/block_memory.h"

namespace penumbra {
namespace {

TEST(BlockMemory, IsUsedAgainByTheNextOfTheSameType) {
  BlockMemory memory;
  const int* first;
  {
    Reused<int> a(memory, 1000, 7);
    Reused<int> b(memory, 10);  // at the same time: another array
    EXPECT_NE(a.data(), b.data());
    EXPECT_EQ(a[999], 7);
    first = a.data();
    b.clear();
  }
  Reused<double> other(memory, 1000);
  EXPECT_NE(static_cast<const void*>(other.data()), static_cast<const void*>(first));
  const Reused<int> c(memory, 1000);
  EXPECT_EQ(c.data(), first);
  EXPECT_EQ(c[999], 0);
}

TEST(BlockMemory, KeepsNothingThatElementsOwn) {
  BlockMemory memory;
  const auto owned = std::make_shared<int>(1);
  { const Reused<std::shared_ptr<int>> a(memory, 5, owned); }
  EXPECT_EQ(owned.use_count(), 1);
  const Reused<std::shared_ptr<int>> b(memory);
  EXPECT_TRUE(b.empty());
}

}  // namespace
}  // namespace penumbra
