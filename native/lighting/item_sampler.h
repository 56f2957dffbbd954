// SPDX-License-Identifier: GPL-3.0-or-later
// Points on a luminaire for one surface point: first a look, then as many as its error needs.
#pragma once

#include <span>
#include <vector>

#include "lighting/bounded_item.h"

namespace penumbra {

class ItemSampler {
 public:
  ItemSampler(const Geometry& geometry, std::span<const Luminaire> luminaires, const Sampler& sampler,
              const std::vector<LitPoint>& points, const BoundedSettings& settings)
      : geometry_(geometry),
        luminaires_(luminaires),
        sampler_(sampler),
        points_(points),
        settings_(settings) {}

  /// Surface point number `point` and a luminaire of that form factor: its unshadowed light.
  BoundedItem make(uint32_t point, uint32_t luminaire, double form_factor) const;

  /// The item's first rays, one to each quarter of the luminaire; all points of a point light are the same.
  void look(BoundedItem& item, LightTally& tally) const;

  /// Adds points up to `count` (16, or a later level), shadow rays included.
  void advance(BoundedItem& item, uint32_t count, LightTally& tally) const;

 private:
  StreamKey key(const BoundedItem& item) const;
  Vec3d unshadowed_glossy(const ShadingPoint& point, const Vec3d& arriving, const Luminaire& luminaire,
                          const StreamKey& key) const;

  const Geometry& geometry_;
  std::span<const Luminaire> luminaires_;
  const Sampler& sampler_;
  const std::vector<LitPoint>& points_;
  const BoundedSettings& settings_;
};

}  // namespace penumbra
