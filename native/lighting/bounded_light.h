// SPDX-License-Identifier: GPL-3.0-or-later
// BOUNDED: direct light on a block of pixels, with no more rays than the tolerance needs.
//
// Unshadowed light is known exactly, so only the visible fraction is sampled: L = L_unshadowed sum(f V) /
// sum(f). A first look of a few rays at each pixel, together with its neighbours', tells where penumbra can
// be; rays go there until a calibrated estimate of the error is below the tolerance.
#pragma once

#include "lighting/lighting.h"

namespace penumbra {

struct BoundedSettings {
  double tolerance;      // display units
  double display_scale;  // display = radiance x this
  uint32_t max_light_samples;
  bool lines = false;  // across luminaires in place of many points, where they may be
};

class BoundedLight final : public Lighting {
 public:
  /// `sampler` must be Owen-scrambled per stream, with max_light_samples points: the error estimate rests on
  /// it.
  BoundedLight(const Geometry& geometry, const Sampler& sampler, const BoundedSettings& settings)
      : geometry_(geometry), sampler_(sampler), settings_(settings) {}

  uint32_t block_side() const override { return 128; }
  /// The gate's reach and the flood's.
  uint32_t halo() const override;
  std::unique_ptr<BlockLighting> begin(const LitBlock& block) const override;

 private:
  const Geometry& geometry_;
  const Sampler& sampler_;
  BoundedSettings settings_;
};

}  // namespace penumbra
