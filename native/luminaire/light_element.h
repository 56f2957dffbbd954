// SPDX-License-Identifier: GPL-3.0-or-later
// Parts of luminaires that are small and far away for most surface points: what a group of luminaires is made
// of.
#pragma once

#include <cstdint>

#include "math/vector.h"

namespace penumbra {

/// From afar its form factor is strength cos cos' / r^2 from the centre, or strength cos / r^2 if it has no
/// normal. Render space.
struct LightElement {
  Vec3d centre;
  Vec3d normal;          // unit; zero: it shines to all sides alike
  Vec3d half_u, half_v;  // the four points centre +- half_u +- half_v have its second moments
  double strength = 0;   // not negative
  double radius = 0;     // none of its points is farther from the centre
  double near = 0;       // surface points nearer than this need form_factor_of()
  bool two_sided = false;
  bool two_sided_near = false;   // it may send light to both sides of surface points that are near
  float u_begin = 0, u_end = 1;  // its part of the emitter's unit square
};

}  // namespace penumbra
