// SPDX-License-Identifier: GPL-3.0-or-later
// Direct light at a surface point: the paper's eq. (4) summed over luminaires.
#pragma once

#include <vector>

#include "lighting/stop_rule.h"
#include "luminaire/luminaire.h"
#include "material/phong.h"
#include "sampling/sampler.h"
#include "visibility/geometry.h"

namespace penumbra {

/// What lighting did, in numbers.
struct LightTally {
  uint64_t light_points = 0;             // used in an estimate
  uint64_t shadow_rays = 0;              // traced, those beyond the stop included
  uint64_t shadow_rays_beyond_stop = 0;  // traced with a packet whose earlier points were enough
  uint64_t decided_without_ray = 0;      // pairs of surface point and luminaire
  bool at_limit = false;                 // some luminaire used max_light_samples without satisfying its rule

  LightTally& operator+=(const LightTally& o) {
    light_points += o.light_points;
    shadow_rays += o.shadow_rays;
    shadow_rays_beyond_stop += o.shadow_rays_beyond_stop;
    decided_without_ray += o.decided_without_ray;
    at_limit = at_limit || o.at_limit;
    return *this;
  }
};

/// Reflected radiance towards the viewer and the sample variance of its estimate, r, g, b.
struct LightEstimate {
  Vec3d radiance, variance;
};

class DirectLight {
 public:
  DirectLight(const Geometry& geometry, const std::vector<AreaLuminaire>& luminaires, const Sampler& sampler,
              const StopSettings& stop);

  /// Light from all luminaires. `stream`: number of this surface point among the frame's, in scan order.
  LightEstimate at(const ShadingPoint& point, uint64_t stream, LightTally& tally) const;

  size_t luminaires() const { return luminaires_.size(); }

 private:
  LightEstimate from(const Luminaire& luminaire, const ShadingPoint& point, const StreamKey& key,
                     LightTally& tally) const;

  const Geometry& geometry_;
  const Sampler& sampler_;
  StopSettings stop_;
  std::vector<Luminaire> luminaires_;
};

}  // namespace penumbra
