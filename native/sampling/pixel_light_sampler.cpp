// SPDX-License-Identifier: GPL-3.0-or-later
#include "sampling/pixel_light_sampler.h"

#include "math/simd.h"
#include "sampling/hash.h"

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

}  // namespace

PixelLightSampler::PixelLightSampler(uint32_t count, uint32_t seed)
    : seed_(seed), pixel_(count), light_(count) {
  for (uint32_t i = 0; i < count; ++i) {
    const FixedPoint2 p = digital_point(kSobolPixel, i), l = digital_point(kSobolLight, i);
    pixel_[i] = {reverse_bits(p.u), reverse_bits(p.v)};
    light_[i] = {reverse_bits(l.u), reverse_bits(l.v)};
  }
}

void PixelLightSampler::scramble(const FixedPoint2* reversed, uint64_t key, uint32_t count, float* u,
                                 float* v) const {
  const uint64_t bits = hash_of(seed_, key);
  owen_scramble(reversed, uint32_t(bits), uint32_t(bits >> 32), count, u, v);
}

}  // namespace penumbra
