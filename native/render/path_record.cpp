// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/path_record.h"

#include <algorithm>
#include <cmath>

#include "material/albedo.h"

namespace penumbra {
namespace {

double average(const Vec3d& c) {
  return (c.x + c.y + c.z) / 3;
}

/// 1 at the mist's start, 0 where all is mist.
double clearness(const MistSettings& mist, double distance) {
  const double depth = mist.depth > 0 ? (distance - mist.start) / mist.depth : distance > mist.start;
  return 1 - std::pow(std::clamp(depth, 0.0, 1.0), mist.exponent);
}

}  // namespace

void add_matte(std::vector<MatteHit>& hits, const MatteHit& hit) {
  for (MatteHit& known : hits) {
    if (known.instance != hit.instance || known.material != hit.material) continue;
    known.weight += hit.weight;
    return;
  }
  hits.push_back(hit);
}

/// Light of its own: seen by the camera, in a first mirror (glossy light, as in Cycles), or in later ones.
void PathRecord::add(const Vec3d& radiance, Part seen, uint32_t mirrors, uint32_t light_group) const {
  parts[mirrors == 0 ? seen : mirrors == 1 ? kGlossyLight : kMirroredLight] += radiance;
  if (light_group != kNoLightGroup) parts[kFirstGroup + light_group] += radiance;
}

void PathRecord::meet(const SurfaceMet& met) const {
  const Closures& closures = met.closures;
  if (max_abs(closures.emission) > 0) shine(met.throughput * closures.emission, met.mirrors, met.light_group);
  if (met.mirrors > 0) return;
  const double opacity = 1 - average(closures.transparency) - closures.holdout,
               weight = average(met.throughput) * std::clamp(opacity, 0.0, 1.0);
  if (mattes && weight > 0) add_matte(*mattes, {met.instance, met.surface.material, weight});
  if (parts.empty()) return;
  parts[kDiffuseColour] += met.throughput * diffuse_albedo(closures);
  parts[kGlossyColour] += met.throughput * glossy_albedo(closures, met.cosine);
  parts[kClearness].x += weight * clearness(*mist, met.distance);
}

void PathRecord::shine(const Vec3d& radiance, uint32_t mirrors, uint32_t light_group) const {
  if (!parts.empty()) add(radiance, kEmission, mirrors, light_group);
}

void PathRecord::leave(const Vec3d& radiance, uint32_t mirrors, uint32_t light_group, bool shown) const {
  if (parts.empty()) return;
  if (shown)
    add(radiance, kEnvironment, mirrors, light_group);
  else
    parts[kEnvironment] += radiance;
}

}  // namespace penumbra
