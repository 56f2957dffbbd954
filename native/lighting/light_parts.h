// SPDX-License-Identifier: GPL-3.0-or-later
// The light of pixels taken apart for passes: by lobe, by the way it came, by light group.
#pragma once

#include <span>
#include <vector>

#include "lighting/lighting.h"

namespace penumbra {

/// What is told of a pixel, r, g, b. What the camera sees it sees directly or through transparent surfaces;
/// colours are what light of 1 from all directions would be reflected to.
enum Part : uint32_t {
  kDiffuseLight,     // from luminaires by diffuse lobes that the camera sees
  kGlossyLight,      // by glossy ones; emission and world in a first mirror
  kMirroredLight,    // from luminaires by surfaces seen in mirrors; emission and world in later mirrors
  kShadowedLight,    // from luminaires by what the camera sees, with
  kUnshadowedLight,  // and without what is in the way
  kDiffuseColour,
  kGlossyColour,
  kEmission,     // that the camera sees
  kEnvironment,  // likewise; of a transparent film, too
  kClearness,    // 1 - mist, in the first component
  kFirstGroup    // of the light groups: all light that comes from them
};

/// Sums for a number of pixels.
class LightParts {
 public:
  LightParts(uint32_t pixels, uint32_t light_groups)
      : count_(kFirstGroup + light_groups), sums_(size_t(pixels) * count_) {}

  uint32_t count() const { return count_; }
  std::span<Vec3d> of(uint32_t pixel) { return {sums_.data() + size_t(pixel) * count_, count_}; }
  std::span<const Vec3d> of(uint32_t pixel) const { return {sums_.data() + size_t(pixel) * count_, count_}; }
  void clear() { sums_.assign(sums_.size(), {}); }

 private:
  uint32_t count_;
  std::vector<Vec3d> sums_;
};

/// A luminaire's light by one lobe's kind, and what it would be if nothing hid it.
struct LobeLight {
  Vec3d seen, unshadowed;
};

/// Adds a luminaire's light to a pixel's parts. mirrored: share of it, r, g, b, that came by way of mirrors.
inline void add_light(std::span<Vec3d> parts, const Luminaire& luminaire, Part lobe, const LobeLight& light,
                      const Vec3d& mirrored) {
  const Vec3d direct = Vec3d{1, 1, 1} - mirrored;
  parts[lobe] += light.seen * direct;
  parts[kMirroredLight] += light.seen * mirrored;
  parts[kShadowedLight] += light.seen * direct;
  parts[kUnshadowedLight] += light.unshadowed * direct;
  if (luminaire.light_group() != kNoLightGroup) parts[kFirstGroup + luminaire.light_group()] += light.seen;
}

/// The same at one surface point, for both kinds of lobes.
inline void add_light(std::span<Vec3d> parts, const Luminaire& luminaire, const LitPoint& lit,
                      const LobeLight& diffuse, const LobeLight& glossy) {
  const double m = lit.mirrored ? 1 : 0;
  add_light(parts, luminaire, kDiffuseLight, diffuse, {m, m, m});
  add_light(parts, luminaire, kGlossyLight, glossy, {m, m, m});
}

}  // namespace penumbra
