// SPDX-License-Identifier: GPL-3.0-or-later
#include "lighting/lobe_colours.h"

namespace penumbra {
namespace {

Reflection on_grid(const ShadingPoint& point, const Luminaire& luminaire) {
  constexpr uint32_t kSide = 8, kCount = kSide * kSide;
  alignas(64) float u[kCount], v[kCount];
  for (uint32_t i = 0; i < kCount; ++i) {
    u[i] = (float(i % kSide) + 0.5f) / kSide;
    v[i] = (float(i / kSide) + 0.5f) / kSide;
  }
  LightPoints points;
  luminaire.evaluate(point.surface, u, v, kCount, points);
  Reflection sum;
  add_reflection(point, points.x, points.y, points.z, points.form_factor, kCount, sum);
  return sum;
}

}  // namespace

DiffuseColour diffuse_colour(const ShadingPoint& point, const Luminaire& luminaire) {
  if (!luminaire.role().diffuse) return {};
  if (!point.material.has_diffuse_lobes) return {point.material.diffuse};
  const Reflection sum = on_grid(point, luminaire);
  if (sum.form_factor == 0) return {{}, 0};
  return {sum.diffuse / sum.form_factor, sum.diffuse_weight / sum.form_factor};
}

Vec3d glossy_colour(const ShadingPoint& point, const Luminaire& luminaire) {
  if (!luminaire.role().glossy) return {};
  if (!point.material.has_glossy_lobes) return point.material.phong;
  const Reflection sum = on_grid(point, luminaire);
  return sum.weight > 0 ? sum.glossy / sum.weight : Vec3d{};
}

}  // namespace penumbra
