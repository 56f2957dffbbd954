// SPDX-License-Identifier: GPL-3.0-or-later
// Luminaires as shading points see them: shape, emission, and what each of their points would send.
#pragma once

#include <cstdint>
#include <vector>

#include "scene/normalization.h"
#include "scene/scene.h"
#include "scene/surface_columns.h"

namespace penumbra {

/// Points on one luminaire as seen from one surface point, or from one each, render space.
struct LightPoints {
  /// From the surface point to the point on the luminaire.
  alignas(64) float x[kBatch], y[kBatch], z[kBatch];
  /// The summands of eq. (4) with visibility, radiance and albedo left out: area x cos cos' / (pi r^2). Their
  /// mean is the form factor F, and L = albedo x L_e x F. Zero: no contribution, no ray needed.
  alignas(64) float form_factor[kBatch];
};

/// What each of a flat luminaire's points sends, single precision.
struct FormFactorTerms {
  Vec3f edge_u, edge_v, normal;
  float scale;  // area / pi
};

/// A flat, one-sided luminaire of constant radiance in render space.
class Luminaire {
 public:
  Luminaire(const AreaLuminaire& description, const Normalization& normalization);

  /// The luminaire emits nothing: no power or no area.
  bool dark() const { return max_abs(radiance_) == 0 || area_ == 0; }
  /// No point of the luminaire is both above the surface's horizon and facing it: an exact test on the
  /// corners of the shape's parallelogram.
  bool unseen_from(const SurfacePoint& surface) const;

  /// Form factor E / (pi L_e) at a surface point where nothing hides the luminaire. Exact for rectangles; an
  /// ellipse counts as the polygon of 64 sides and equal area around it (relative error 1e-6 from one
  /// radius away, tests/native/test_luminaire.cpp).
  double form_factor(const SurfacePoint& surface) const;
  /// The same for many surface points at once.
  void form_factors(const SurfaceColumns& surfaces, double* out) const;

  /// Maps points of the unit square to the luminaire, uniformly in area, and evaluates them.
  void evaluate(const SurfacePoint& surface, const float* u, const float* v, uint32_t count,
                LightPoints& out) const;
  /// One point of the luminaire for each of many surface points: (u, v)[i] for surface i.
  void evaluate_each(const SurfaceColumns& surfaces, const float* u, const float* v, LightPoints& out) const;

  const Vec3d& radiance() const { return radiance_; }
  bool casts_shadow() const { return cast_shadow_; }

 private:
  void make_outline();
  /// The unit square to the parallelogram's coordinates; u and v may be replaced by s and t, which hold the
  /// result.
  void to_shape(const float*& u, const float*& v, uint32_t count, float* s, float* t) const;

  LuminaireShape shape_;
  std::vector<Vec3d> vertices_, edges_;  // outline relative to corner_, and from each vertex to the next
  Vec3d corner_, edge_u_, edge_v_;       // of the parallelogram that holds the shape
  Vec3d normal_;                         // unit, on the emitting side
  double area_;                          // of the shape, render space
  Vec3d radiance_;
  FormFactorTerms terms_;
  bool cast_shadow_;
};

/// True area |M x_axis x M y_axis| of a luminaire's shape (world units).
double area_of(LuminaireShape shape, const Affine& world_from_light, double size_x, double size_y);

}  // namespace penumbra
