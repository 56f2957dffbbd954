// SPDX-License-Identifier: GPL-3.0-or-later
// The sun: a disk of directions, or one direction.
#pragma once

#include "luminaire/cone.h"
#include "scene/luminaires.h"

namespace penumbra {

/// Form factors are per irradiance / pi of a surface that faces the sun: its radiance is that over sin^2 of
/// its half angle.
class SunEmitter final : public Emitter {
 public:
  explicit SunEmitter(const SunLuminaire& description);

  bool is_point() const override { return cone_.sine_squared == 0; }
  double form_factor(const SurfacePoint& surface) const override;
  /// Uniformly in solid angle.
  void evaluate(const SurfacePoint& surface, const float* u, const float* v, uint32_t count,
                LightPoints& out) const override;
  double seen_along(const SightLine& line) const override;

 private:
  Cone cone_;
};

}  // namespace penumbra
