// SPDX-License-Identifier: GPL-3.0-or-later
// A luminaire: what it looks like to shading points, its radiance, and whether it casts shadows.
#pragma once

#include <memory>

#include "luminaire/emitter.h"
#include "scene/luminaires.h"
#include "scene/normalization.h"

namespace penumbra {

/// In render space, of any kind; lighting need not know which.
class Luminaire {
 public:
  Luminaire(const LuminaireDescription& description, const Normalization& normalization);
  Luminaire(std::string name, std::shared_ptr<const Emitter> emitter, const Vec3d& radiance, bool cast_shadow)
      : name_(std::move(name)),
        emitter_(std::move(emitter)),
        radiance_(radiance),
        cast_shadow_(cast_shadow) {}

  /// The luminaire emits nothing: no power or no area.
  bool dark() const { return max_abs(radiance_) == 0 || emitter_->dark(); }
  bool is_point() const { return emitter_->is_point(); }
  bool is_wide() const { return emitter_->is_wide(); }
  bool unseen_from(const SurfacePoint& surface) const { return emitter_->unseen_from(surface); }
  double form_factor(const SurfacePoint& surface) const { return emitter_->form_factor(surface); }
  void form_factors(const SurfaceColumns& surfaces, double* out) const {
    emitter_->form_factors(surfaces, out);
  }
  void evaluate(const SurfacePoint& surface, const float* u, const float* v, uint32_t count,
                LightPoints& out) const {
    emitter_->evaluate(surface, u, v, count, out);
  }
  void evaluate_each(const SurfaceColumns& surfaces, const float* u, const float* v, LightPoints& out) const {
    emitter_->evaluate_each(surfaces, u, v, out);
  }

  /// What form factors are multiplied with: the radiance of a luminaire of some size, the intensity of a
  /// point, the irradiance / pi of a direction.
  const Vec3d& radiance() const { return radiance_; }
  const std::string& name() const { return name_; }
  bool casts_shadow() const { return cast_shadow_; }

 private:
  std::string name_;
  std::shared_ptr<const Emitter> emitter_;
  Vec3d radiance_;
  bool cast_shadow_;
};

}  // namespace penumbra
