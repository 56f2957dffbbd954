// SPDX-License-Identifier: GPL-3.0-or-later
#include "sampling/random_samplers.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "sampling/drand48.h"

namespace penumbra {
namespace {

/// The highest 24 of drand48's 48 bits: exact in a float, and never 1.
float to_float(uint64_t bits) {
  return float(bits >> 24) * 0x1p-24f;
}

}  // namespace

void PrsSampler::points(const StreamKey& key, uint32_t first, uint32_t count, float* u, float* v) const {
  Drand48 random(settings_.seed);
  random.jump(2 * (key.index * settings_.samples_per_stream + first));
  for (uint32_t i = 0; i < count; ++i) {
    u[i] = to_float(random.next_bits());
    v[i] = to_float(random.next_bits());
  }
}

SprsSampler::SprsSampler(const SamplerSettings& settings)
    : jitter_(settings), side_(uint32_t(std::lround(std::sqrt(double(settings.samples_per_stream))))) {
  if (uint64_t(side_) * side_ != settings.samples_per_stream)
    throw std::invalid_argument("sampler SPRS needs a square number of light_samples, not " +
                                std::to_string(settings.samples_per_stream));
}

void SprsSampler::points(const StreamKey& key, uint32_t first, uint32_t count, float* u, float* v) const {
  jitter_.points(key, first, count, u, v);
  for (uint32_t i = 0; i < count; ++i) {
    const uint32_t cell = std::min(first + i, side_ * side_ - 1);
    u[i] = inside_cell(cell % side_, u[i]);
    v[i] = inside_cell(cell / side_, v[i]);
  }
}

float SprsSampler::inside_cell(uint32_t cell, float jitter) const {
  // In units of 2^-24 and rounded towards the cell's inside, so that no point lands in the next cell.
  const uint64_t low = uint64_t(cell) << 24, moved = low + uint64_t(jitter * 0x1p24f);
  return float(std::max(moved / side_, (low + side_ - 1) / side_)) * 0x1p-24f;
}

}  // namespace penumbra
