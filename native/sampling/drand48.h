// SPDX-License-Identifier: GPL-3.0-or-later
// The linear congruential generator behind POSIX drand48(), with jump-ahead.
#pragma once

#include <cstdint>

namespace penumbra {

/// X' = a X + c mod 2^48, a = 0x5DEECE66D, c = 11 (POSIX.1); a variate is X / 2^48.
class Drand48 {
 public:
  /// The state after srand48(seed).
  explicit Drand48(uint32_t seed) : state_((uint64_t(seed) << 16) | 0x330E) {}

  /// The next 48 bits; drand48() returns them times 2^-48.
  uint64_t next_bits() { return state_ = (kMultiplier * state_ + kIncrement) & kMask; }

  /// Skips n variates in O(log n): n-fold composition of the affine map by repeated squaring (F. Brown,
  /// 1994).
  void jump(uint64_t n) {
    uint64_t a = kMultiplier, c = kIncrement, a_total = 1, c_total = 0;
    for (; n; n >>= 1) {
      if (n & 1) {
        a_total = a_total * a;
        c_total = c_total * a + c;
      }
      c = c * (a + 1);
      a = a * a;
    }
    state_ = (a_total * state_ + c_total) & kMask;
  }

 private:
  static constexpr uint64_t kMultiplier = 0x5DEECE66D, kIncrement = 11, kMask = (uint64_t(1) << 48) - 1;
  uint64_t state_;
};

}  // namespace penumbra
