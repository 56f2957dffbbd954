// SPDX-License-Identifier: GPL-3.0-or-later
#include "lighting/light_batch.h"

#include <algorithm>

namespace penumbra {

uint32_t LightBatch::trace(const ShadingPoint& point, const Luminaire& luminaire, const ShadowRays& rays,
                           const float* u, const float* v, uint32_t count, KnownPoints known) {
  luminaire.evaluate(point.surface, u, v, count, points);
  const float* f = points.form_factor;
  alignas(64) int traced[kBatch];
  std::copy(f, f + count, diffuse);
  std::copy(f, f + count, seen_diffuse);
  // Not those that are known, but what transparent surfaces dimmed is not.
  const uint32_t sure = (known.lit | known.dark) & ~(known.lit & known.dark);
  for (uint32_t i = 0; i < count && sure >> i; ++i)
    if (sure >> i & 1) seen_diffuse[i] = 0;
  uint32_t traced_rays = 0;
  if (luminaire.casts_shadow())
    traced_rays = rays.hide(count, points.x, points.y, points.z, seen_diffuse, traced);
  for (uint32_t i = 0; i < count && sure >> i; ++i)
    if (sure >> i & known.lit >> i & 1) seen_diffuse[i] = f[i];
  if (point.has_glossy) {
    evaluate_glossy(point, points.x, points.y, points.z, f, count, glossy);
    evaluate_glossy(point, points.x, points.y, points.z, seen_diffuse, count, seen_glossy);
  }
  weigh_diffuse(point, points.x, points.y, points.z, count, diffuse);
  weigh_diffuse(point, points.x, points.y, points.z, count, seen_diffuse);
  return traced_rays;
}

}  // namespace penumbra
