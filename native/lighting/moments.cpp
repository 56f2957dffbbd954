// SPDX-License-Identifier: GPL-3.0-or-later
#include "lighting/moments.h"

#include "math/simd.h"

namespace penumbra {

PENUMBRA_VECTORIZED
PacketSums sum_packets(const float* a, const float* b, uint32_t packets) {
  double s[kPacket] = {}, t[kPacket] = {};
  for (uint32_t packet = 0; packet < packets; ++packet) {
    for (uint32_t i = 0; i < kPacket; ++i) {
      s[i] += double(a[packet * kPacket + i]);
      t[i] += double(a[packet * kPacket + i]) * double(b[packet * kPacket + i]);
    }
  }
  for (uint32_t half = kPacket / 2; half; half /= 2) {
    for (uint32_t i = 0; i < half; ++i) {
      s[i] += s[i + half];
      t[i] += t[i + half];
    }
  }
  return {s[0], t[0]};
}

}  // namespace penumbra
