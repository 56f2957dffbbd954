// SPDX-License-Identifier: GPL-3.0-or-later
#include "material/albedo.h"

#include "material/lobes.h"

namespace penumbra {

Vec3d diffuse_albedo(const Closures& closures) {
  Vec3d sum = closures.diffuse;
  for (uint32_t i = 0; i < closures.lobe_count; ++i)
    if (is_diffuse(closures.lobes[i].kind)) sum += Vec3d(closures.lobes[i].colour);
  return sum;
}

Vec3d glossy_albedo(const Closures& closures, double cosine) {
  Vec3d sum = closures.phong + closures.mirror;
  for (uint32_t i = 0; i < closures.lobe_count; ++i) {
    const Lobe& lobe = closures.lobes[i];
    if (is_diffuse(lobe.kind)) continue;
    const float edge = lobe.ior != 0 ? fresnel_edge(float(cosine), lobe.ior) : 0;
    sum += Vec3d(lobe.colour * (1 - edge) + lobe.edge * edge);
  }
  return sum;
}

}  // namespace penumbra
