// SPDX-License-Identifier: GPL-3.0-or-later
// Point lights and spots: a sphere, a disk that faces the shading point, or a point.
#pragma once

#include <optional>

#include "luminaire/cone.h"
#include "scene/luminaires.h"
#include "scene/normalization.h"

namespace penumbra {

/// Form factors are per intensity in render space, whatever the radius.
class PointEmitter final : public Emitter {
 public:
  PointEmitter(const PointLuminaire& description, const Normalization& normalization);

  bool is_point() const override { return radius_ == 0; }
  bool unseen_from(const SurfacePoint& surface) const override;
  /// Closed form; by 256 or 4096 shading-only points where a spot's cone of some radius fades.
  double form_factor(const SurfacePoint& surface) const override;
  /// Uniformly in the solid angle that the surface point sees.
  void evaluate(const SurfacePoint& surface, const float* u, const float* v, uint32_t count,
                LightPoints& out) const override;
  double seen_along(const SightLine& line) const override;
  std::vector<LightElement> elements() const override;

 private:
  /// A spot's factor for light that leaves in a direction.
  struct Spot {
    Affine axes;  // render_from_light
    double cos_half, inverse_width;
    bool cosine_falloff;
    bool rigid;  // the axes keep angles

    double attenuation(const Vec3d& direction) const;
    void attenuate(uint32_t count, LightPoints& points) const;
  };
  struct View {
    Vec3d to_centre;
    double distance;
    bool inside;  // the surface point is in the sphere: light from everywhere
    Cone cone;
  };
  View view_from(const SurfacePoint& surface) const;
  /// The form factor with the spot's cone, where it is known without points.
  std::optional<double> spot_form_factor(const View& view, const Vec3d& normal) const;

  RoundShape shape_;
  Vec3d centre_;
  double radius_;            // 0: less than single precision can tell from a point
  double per_radiance_ = 1;  // intensity 1 is this radiance of a sphere or disk
  std::optional<Spot> spot_;
};

}  // namespace penumbra
