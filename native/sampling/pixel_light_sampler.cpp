// SPDX-License-Identifier: GPL-3.0-or-later
#include "sampling/pixel_light_sampler.h"

#include "math/simd.h"
#include "sampling/hash.h"
#include "sampling/sampler.h"

namespace penumbra {
namespace {

/// A packet's points of the sequence, digits reversed, and how each is scrambled.
struct Columns {
  alignas(64) uint32_t u[kPacket], v[kPacket], seed_u[kPacket], seed_v[kPacket];
};

PENUMBRA_VECTORIZED
void owen_scramble(const Columns& c, uint32_t count, float* u, float* v) {
  for (uint32_t i = 0; i < count; ++i) {
    u[i] = float(int32_t(reverse_bits(owen_scramble_reversed(c.u[i], c.seed_u[i])) >> 8)) * 0x1p-24f;
    v[i] = float(int32_t(reverse_bits(owen_scramble_reversed(c.v[i], c.seed_v[i])) >> 8)) * 0x1p-24f;
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

template <typename Seed>
void PixelLightSampler::scramble(const std::vector<FixedPoint2>& reversed,
                                 std::span<const SampleRange> ranges, Seed seed, float* u, float* v) {
  Columns columns;
  uint32_t count = 0;
  for (const SampleRange& range : ranges) {
    const uint64_t bits = seed(range.key);
    for (uint32_t i = 0; i < range.count; ++i, ++count) {
      columns.u[count] = reversed[range.first + i].u, columns.v[count] = reversed[range.first + i].v;
      columns.seed_u[count] = uint32_t(bits), columns.seed_v[count] = uint32_t(bits >> 32);
    }
  }
  owen_scramble(columns, count, u, v);
}

void PixelLightSampler::pixel(std::span<const SampleRange> ranges, float* u, float* v) const {
  scramble(
      pixel_, ranges, [this](uint64_t key) { return hash_of(seed_, key); }, u, v);
}

void PixelLightSampler::light(std::span<const SampleRange> ranges, float* u, float* v) const {
  scramble(
      light_, ranges, [this](uint64_t key) { return hash_of(seed_, key); }, u, v);
}

void PixelLightSampler::lens(std::span<const SampleRange> ranges, float* u, float* v) const {
  scramble(
      lens_, ranges, [this](uint64_t key) { return hash_of(seed_, hash_of(kLensKey, key)); }, u, v);
}

void PixelLightSampler::time(std::span<const SampleRange> ranges, float* u) const {
  alignas(64) float unused[kPacket];
  scramble(
      time_, ranges, [this](uint64_t key) { return hash_of(seed_, hash_of(kTimeKey, key)); }, u, unused);
}

}  // namespace penumbra
