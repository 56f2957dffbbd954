// SPDX-License-Identifier: GPL-3.0-or-later
// Emissive meshes: triangles of constant radiance each.
#pragma once

#include <vector>

#include "luminaire/emitter.h"
#include "scene/luminaires.h"
#include "scene/normalization.h"

namespace penumbra {

/// What of a closed mesh faces away from a point outside it is hidden by the rest for sure, so it counts as
/// one-sided there; parts of it that hide others are found by rays, as all occluders are.
class MeshEmitter final : public Emitter {
 public:
  MeshEmitter(const MeshLuminaire& description, const Normalization& normalization);

  bool dark() const override { return power_ == 0; }
  /// It is as large as half the scene.
  bool is_wide() const override { return max_abs(bounds_.extent()) > 1; }
  /// By the corners of its bounding box: it may be false where no triangle is above the horizon.
  bool unseen_from(const SurfacePoint& surface) const override;
  /// Triangles that are near or cross the horizon in closed form, others by three points each (relative error
  /// 2e-4, tests/native/test_mesh_emitter.cpp).
  double form_factor(const SurfacePoint& surface) const override;
  /// Uniformly in area times weight.
  void evaluate(const SurfacePoint& surface, const float* u, const float* v, uint32_t count,
                LightPoints& out) const override;
  /// One a triangle.
  std::vector<LightElement> elements() const override;
  double form_factor_of(uint32_t element, const SurfacePoint& surface) const override;

 private:
  struct Triangle {
    Vec3d corner, edge1, edge2, normal;
    double weight;  // what its radiance is multiplied with
  };
  /// Do triangles send to the point on the side of their normals alone? Also if it lies outside a closed
  /// mesh, by the bounding box.
  bool one_sided_from(const Vec3d& point) const;
  double triangle_form_factor(const Triangle& triangle, const SurfacePoint& surface) const;

  std::vector<Triangle> triangles_;  // along a space-filling curve, so that near points of u are near
  std::vector<float> cumulative_;    // area x weight, from 0 to 1; one more than triangles
  std::vector<float> columns_[13];   // for the loop over all triangles, see mesh_emitter.cpp
  Box bounds_;
  double power_ = 0;  // sum of area x weight
  bool closed_, one_sided_;
};

}  // namespace penumbra
