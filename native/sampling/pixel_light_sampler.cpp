// SPDX-License-Identifier: GPL-3.0-or-later
#include "sampling/pixel_light_sampler.h"

#include "sampling/hash.h"

namespace penumbra {

PixelLightSampler::PixelLightSampler(uint32_t count, uint32_t seed)
    : seed_(seed), pixel_(count), light_(count) {
  for (uint32_t i = 0; i < count; ++i) {
    const FixedPoint2 p = digital_point(kSobolPixel, i), l = digital_point(kSobolLight, i);
    pixel_[i] = {reverse_bits(p.u), reverse_bits(p.v)};
    light_[i] = {reverse_bits(l.u), reverse_bits(l.v)};
  }
}

UnitPoint PixelLightSampler::scrambled(FixedPoint2 reversed, uint64_t key) const {
  const uint64_t bits = hash_of(seed_, key);
  const uint32_t u = reverse_bits(owen_scramble_reversed(reversed.u, uint32_t(bits)));
  const uint32_t v = reverse_bits(owen_scramble_reversed(reversed.v, uint32_t(bits >> 32)));
  return {float(u >> 8) * 0x1p-24f, float(v >> 8) * 0x1p-24f};
}

}  // namespace penumbra
