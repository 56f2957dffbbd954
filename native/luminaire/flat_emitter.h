// SPDX-License-Identifier: GPL-3.0-or-later
// Area lights: flat, one-sided, of constant radiance.
#pragma once

#include <vector>

#include "luminaire/emitter.h"
#include "scene/luminaires.h"
#include "scene/normalization.h"

namespace penumbra {

/// What each of its points sends, single precision.
struct FormFactorTerms {
  Vec3f edge_u, edge_v, normal;
  float scale;  // area / pi
};

class FlatEmitter final : public Emitter {
 public:
  FlatEmitter(const AreaLuminaire& description, const Normalization& normalization);

  bool dark() const override { return area_ == 0; }
  /// An exact test on the corners of the shape's parallelogram.
  bool unseen_from(const SurfacePoint& surface) const override;
  /// Exact for rectangles; an ellipse counts as the polygon of 64 sides and equal area around it (relative
  /// error 1e-6 from one radius away, tests/native/test_luminaire.cpp).
  double form_factor(const SurfacePoint& surface) const override;
  void form_factors(const SurfaceColumns& surfaces, double* out) const override;
  /// Uniformly in area, but for what a rectangle has below the surface's horizon.
  void evaluate(const SurfacePoint& surface, const float* u, const float* v, uint32_t count,
                LightPoints& out) const override;
  void evaluate_each(const SurfaceColumns& surfaces, const float* u, const float* v, uint32_t points,
                     LightPoints& out) const override;
  std::optional<Parallelogram> parallelogram() const override {
    if (shape_ != LuminaireShape::kRectangle) return std::nullopt;
    return Parallelogram{corner_, edge_u_, edge_v_};
  }
  double seen_along(const SightLine& line) const override;
  std::vector<LightElement> elements() const override;

 private:
  void make_outline();
  /// The unit square to the parallelogram's coordinates; u and v may be replaced by s and t, which hold the
  /// result.
  void to_shape(const float*& u, const float*& v, uint32_t count, float* s, float* t) const;

  LuminaireShape shape_;
  std::vector<Vec3d> vertices_, edges_;  // outline relative to corner_, and from each vertex to the next
  Vec3d corner_, edge_u_, edge_v_;       // of the parallelogram that holds the shape
  Vec3d cut_u_, cut_v_;                  // its edges, if points may be taken from a part of it
  Vec3d normal_;                         // unit, on the emitting side
  double area_;                          // of the shape, render space
  FormFactorTerms terms_;
};

/// True area |M x_axis x M y_axis| of a luminaire's shape (world units).
double area_of(LuminaireShape shape, const Affine& world_from_light, double size_x, double size_y);

}  // namespace penumbra
