// SPDX-License-Identifier: GPL-3.0-or-later
// A luminaire: what it looks like to shading points, its radiance, and whether it casts shadows.
#pragma once

#include <memory>

#include "luminaire/emitter.h"
#include "scene/luminaires.h"
#include "scene/normalization.h"
#include "scene/object_traits.h"

namespace penumbra {

/// In render space, of any kind; lighting need not know which.
class Luminaire {
 public:
  Luminaire(const LuminaireDescription& description, const Normalization& normalization,
            uint32_t light_group = kNoLightGroup);
  Luminaire(std::string name, std::shared_ptr<const Emitter> emitter, const Vec3d& radiance, bool cast_shadow,
            LuminaireRole role = {}, uint32_t light_group = kNoLightGroup)
      : name_(std::move(name)),
        emitter_(std::move(emitter)),
        radiance_(radiance),
        cast_shadow_(cast_shadow),
        role_(std::move(role)),
        light_group_(light_group) {}

  /// The luminaire emits nothing: no power or no area; or nothing reflects it.
  bool dark() const {
    return max_abs(radiance_) == 0 || emitter_->dark() || !(role_.diffuse || role_.glossy);
  }
  bool is_point() const { return emitter_->is_point(); }
  bool is_wide() const { return emitter_->is_wide(); }
  bool unseen_from(const SurfacePoint& surface) const {
    return !lights(surface.receiver_set) || emitter_->unseen_from(surface);
  }
  double form_factor(const SurfacePoint& surface) const {
    return lights(surface.receiver_set) ? emitter_->form_factor(surface) : 0;
  }
  void form_factors(const SurfaceColumns& surfaces, double* out) const;
  void evaluate(const SurfacePoint& surface, const float* u, const float* v, uint32_t count,
                LightPoints& out) const;
  void evaluate_each(const SurfaceColumns& surfaces, const float* u, const float* v, LightPoints& out,
                     uint32_t points = 1) const {
    emitter_->evaluate_each(surfaces, u, v, points, out);
  }
  /// Times radiance(): what a line of sight sees of the luminaire itself.
  double seen_along(const SightLine& line) const { return emitter_->seen_along(line); }

  std::vector<LightElement> elements() const { return emitter_->elements(); }
  const Emitter& emitter() const { return *emitter_; }

  /// What form factors are multiplied with: the radiance of a luminaire of some size, the intensity of a
  /// point, the irradiance / pi of a direction.
  const Vec3d& radiance() const { return radiance_; }
  const std::string& name() const { return name_; }
  bool casts_shadow() const { return cast_shadow_; }
  const LuminaireRole& role() const { return role_; }
  ShadowKind shadow_kind() const { return {role_.shadow_rays, channel_}; }
  /// What it gives of one channel, for scenes where shadows are coloured.
  Luminaire of_channel(uint8_t channel) const;
  /// Its number; kNoLightGroup: none.
  uint32_t light_group() const { return light_group_; }

 private:
  /// Does it light the instances of a receiver set?
  bool lights(uint32_t receiver_set) const {
    return role_.receivers.empty() ||
           (receiver_set < role_.receivers.size() && role_.receivers[receiver_set]);
  }

  std::string name_;
  std::shared_ptr<const Emitter> emitter_;
  Vec3d radiance_;
  bool cast_shadow_;
  LuminaireRole role_;
  uint32_t light_group_;
  uint8_t channel_ = kAllChannels;
};

}  // namespace penumbra
