// SPDX-License-Identifier: GPL-3.0-or-later
#include "sampling/pixel_light_sampler.h"

#include "math/simd.h"
#include "sampling/hash.h"
#include "sampling/sampler.h"

namespace penumbra {
namespace {

PENUMBRA_VECTORIZED
void owen_scramble(const FixedPoint2* reversed, uint32_t seed_u, uint32_t seed_v, uint32_t count, float* u,
                   float* v) {
  for (uint32_t i = 0; i < count; ++i) {
    u[i] = float(reverse_bits(owen_scramble_reversed(reversed[i].u, seed_u)) >> 8) * 0x1p-24f;
    v[i] = float(reverse_bits(owen_scramble_reversed(reversed[i].v, seed_v)) >> 8) * 0x1p-24f;
  }
}

std::vector<FixedPoint2> table(const DigitalMatrices& matrices, uint32_t count) {
  std::vector<FixedPoint2> reversed(count);
  for (uint32_t i = 0; i < count; ++i) {
    const FixedPoint2 p = digital_point(matrices, i);
    reversed[i] = {reverse_bits(p.u), reverse_bits(p.v)};
  }
  return reversed;
}

/// Tell the lens' and the time's scrambling from the pixel's.
constexpr uint64_t kLensKey = 0x6C656E73, kTimeKey = 0x74696D65;

}  // namespace

PixelLightSampler::PixelLightSampler(uint32_t count, uint32_t seed, bool lens_and_time)
    : seed_(seed),
      pixel_(table(kSobolPixel, count)),
      light_(table(kSobolLight, count)),
      lens_(table(kSobolLens, lens_and_time ? count : 0)),
      time_(table(kSobolTime, lens_and_time ? count : 0)) {}

void PixelLightSampler::lens(uint64_t key, uint32_t first, uint32_t count, float* u, float* v) const {
  scramble(&lens_[first], hash_of(kLensKey, key), count, u, v);
}

/// count: at most kPacket.
void PixelLightSampler::time(uint64_t key, uint32_t first, uint32_t count, float* u) const {
  alignas(64) float unused[kPacket];
  scramble(&time_[first], hash_of(kTimeKey, key), count, u, unused);
}

void PixelLightSampler::scramble(const FixedPoint2* reversed, uint64_t key, uint32_t count, float* u,
                                 float* v) const {
  const uint64_t bits = hash_of(seed_, key);
  owen_scramble(reversed, uint32_t(bits), uint32_t(bits >> 32), count, u, v);
}

}  // namespace penumbra
