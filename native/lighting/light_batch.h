// SPDX-License-Identifier: GPL-3.0-or-later
// Points on a luminaire, seen from one surface point.
#pragma once

#include "luminaire/luminaire.h"
#include "material/shading_point.h"
#include "visibility/shadow_rays.h"

namespace penumbra {

/// Points whose rays were traced before: bits of the first ones. Dimmed by transparent surfaces: both.
struct KnownPoints {
  uint32_t lit = 0, dark = 0;
};

/// The integrands of at most kBatch points, without and with visibility: of weigh_diffuse(), and of
/// evaluate_glossy() where the surface has such lobes (else not set).
struct LightBatch {
  alignas(64) float diffuse[kBatch], seen_diffuse[kBatch], glossy[kBatch], seen_glossy[kBatch];
  LightPoints points;  // form factors without visibility

  /// Evaluates and traces them; `rays` are those of the point and of the luminaire's kind. Returns the number
  /// of rays.
  uint32_t trace(const ShadingPoint& point, const Luminaire& luminaire, const ShadowRays& rays,
                 const float* u, const float* v, uint32_t count, KnownPoints known = {});
};

}  // namespace penumbra
