// SPDX-License-Identifier: GPL-3.0-or-later
// What shadow rays need to know about materials.
#pragma once

#include "scene/surface_point.h"

namespace penumbra {

/// Immutable, so that threads share it.
class Opacity {
 public:
  virtual ~Opacity() = default;

  /// Whether a material lets light through somewhere.
  virtual bool may_be_transparent(uint32_t material) const = 0;
  /// Share of the light that goes straight through a surface point, 0 ... 1, along a ray's direction: of one
  /// channel, or of their mean.
  virtual double transparency(const PlacedPoint& surface, const Vec3d& direction, uint8_t channel) const = 0;
};

}  // namespace penumbra
