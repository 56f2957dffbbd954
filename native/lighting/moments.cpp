// SPDX-License-Identifier: GPL-3.0-or-later
#include "lighting/moments.h"

#include "math/simd.h"

namespace penumbra {
namespace {

/// The lanes' sum, as a tree.
inline double sum_lanes(const double* s) {
  static_assert(kPacket == 16);
  double quarter[4];
  for (size_t i = 0; i < 4; ++i) quarter[i] = (s[i] + s[i + 8]) + (s[i + 4] + s[i + 12]);
  return (quarter[0] + quarter[2]) + (quarter[1] + quarter[3]);
}

}  // namespace

/// One step a loop: compilers unroll loops of several before they think of vectors.
PENUMBRA_VECTORIZED
PacketSums sum_packets(const float* a, const float* b, uint32_t packets) {
  double s[kPacket] = {}, t[kPacket] = {};
  for (const float* end = a + size_t(packets) * kPacket; a < end; a += kPacket, b += kPacket) {
    double x[kPacket], y[kPacket];
    for (size_t i = 0; i < kPacket; ++i) x[i] = double(a[i]);
    for (size_t i = 0; i < kPacket; ++i) y[i] = double(b[i]);
    for (size_t i = 0; i < kPacket; ++i) s[i] += x[i];
    for (size_t i = 0; i < kPacket; ++i) t[i] += x[i] * y[i];
  }
  return {sum_lanes(s), sum_lanes(t)};
}

}  // namespace penumbra
