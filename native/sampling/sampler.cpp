// SPDX-License-Identifier: GPL-3.0-or-later
#include "sampling/sampler.h"

#include <stdexcept>

#include "sampling/random_samplers.h"
#include "sampling/sequence_sampler.h"

namespace penumbra {

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
