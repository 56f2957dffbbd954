// SPDX-License-Identifier: GPL-3.0-or-later
// PRS and SPRS: the paper's pseudo-random points, from the real drand48 sequence.
#pragma once

#include "sampling/sampler.h"

namespace penumbra {

/// Pairs of drand48 variates; stream k starts at pair k * samples_per_stream of the one sequence.
class PrsSampler final : public Sampler {
 public:
  explicit PrsSampler(const SamplerSettings& settings) : settings_(settings) {}
  void points(const StreamKey& key, uint32_t first, uint32_t count, float* u, float* v) const override;

 private:
  SamplerSettings settings_;
};

/// n x n cells with one drand48 pair in each, row by row.
class SprsSampler final : public Sampler {
 public:
  explicit SprsSampler(const SamplerSettings& settings);
  void points(const StreamKey& key, uint32_t first, uint32_t count, float* u, float* v) const override;

 private:
  float inside_cell(uint32_t cell, float jitter) const;

  PrsSampler jitter_;
  uint32_t side_;
};

}  // namespace penumbra
