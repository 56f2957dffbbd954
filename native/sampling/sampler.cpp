// SPDX-License-Identifier: GPL-3.0-or-later
#include "sampling/sampler.h"

#include <stdexcept>

#include "sampling/random_samplers.h"
#include "sampling/sequence_sampler.h"

namespace penumbra {

void Sampler::first_points(std::span<const StreamKey> keys, uint32_t count, float* u, float* v) const {
  alignas(64) float packet_u[kPacket], packet_v[kPacket];
  for (size_t i = 0; i < keys.size(); ++i) {
    points(keys[i], 0, kPacket, packet_u, packet_v);
    for (uint32_t k = 0; k < count; ++k) {
      u[k * keys.size() + i] = packet_u[k];
      v[k * keys.size() + i] = packet_v[k];
    }
  }
}

std::unique_ptr<Sampler> make_sampler(const SamplerSettings& settings) {
  if (settings.samples_per_stream == 0)
    throw std::invalid_argument("a sampler needs at least one light sample");
  switch (settings.kind) {
    case SamplerKind::kPrs:
      return std::make_unique<PrsSampler>(settings);
    case SamplerKind::kSprs:
      return std::make_unique<SprsSampler>(settings);
    default:
      return std::make_unique<SequenceSampler>(settings);
  }
}

}  // namespace penumbra
