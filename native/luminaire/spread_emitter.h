// SPDX-License-Identifier: GPL-3.0-or-later
// Area lights whose light leaves in a narrow cone, as through the grid of a soft box.
#pragma once

#include "luminaire/emitter.h"
#include "scene/luminaires.h"
#include "scene/normalization.h"

namespace penumbra {

/// Radiance falls as 1 - tan(angle) / tan(spread / 2) from the normal; the power is that of all directions.
class SpreadEmitter final : public Emitter {
 public:
  SpreadEmitter(const AreaLuminaire& description, const Normalization& normalization);

  bool dark() const override { return size_ == 0; }
  bool unseen_from(const SurfacePoint& surface) const override;
  /// By 32 x 32 shading-only points.
  double form_factor(const SurfacePoint& surface) const override;
  /// Uniformly in the parallelogram around what shines at the surface point.
  void evaluate(const SurfacePoint& surface, const float* u, const float* v, uint32_t count,
                LightPoints& out) const override;
  double seen_along(const SightLine& line) const override;
  std::vector<LightElement> elements() const override;

 private:
  /// The part of the light's parallelogram, coordinates 0 ... 1, from which light can reach a point.
  struct Part {
    double low[2], high[2];
    bool empty() const { return low[0] >= high[0] || low[1] >= high[1]; }
  };
  Part part_seen_from(const Vec3d& point) const;

  bool is_ellipse_;
  Vec3d corner_, edge_u_, edge_v_, normal_;
  double size_;            // area of the parallelogram, render space
  double tangent_, peak_;  // of half the spread; radiance along the normal, relative
};

}  // namespace penumbra
