// SPDX-License-Identifier: GPL-3.0-or-later
// FIXED, PAPER and VARIANCE: the paper's eq. (4) point by point, without regard to neighbours.
#pragma once

#include "lighting/light_parts.h"
#include "lighting/stop_rule.h"

namespace penumbra {

class DirectLight final : public Lighting {
 public:
  /// display_scale: display value = radiance x this.
  DirectLight(const Geometry& geometry, const Sampler& sampler, const StopSettings& stop,
              double display_scale)
      : geometry_(geometry), sampler_(sampler), stop_(stop), display_scale_(display_scale) {}

  uint32_t block_side() const override { return kTile; }
  uint32_t halo() const override { return 0; }
  std::unique_ptr<BlockLighting> begin(const LitBlock& block) const override;

 private:
  class OnBlock;
  /// Reflected radiance towards the viewer and the sample variance of its estimate, r, g, b.
  struct Estimate {
    Vec3d radiance, variance;
    uint64_t points = 0;
    bool at_limit = false;
  };
  struct Parts {
    LobeLight diffuse, glossy;
  };
  Estimate from(const Luminaire& luminaire, const ShadingPoint& point, const StreamKey& key,
                LightTally& tally, Parts* parts) const;

  const Geometry& geometry_;
  const Sampler& sampler_;
  StopSettings stop_;
  double display_scale_;
};

}  // namespace penumbra
