// SPDX-License-Identifier: GPL-3.0-or-later
// What light comes from, as shading points see it: a shape, and what each of its points would send.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "luminaire/light_element.h"
#include "math/parallelogram.h"
#include "scene/surface_columns.h"

namespace penumbra {

/// Points on one luminaire as seen from one surface point, or from one each, render space.
struct LightPoints {
  /// From the surface point to the point on the luminaire; for a distant one, beyond the scene.
  alignas(64) float x[kBatch], y[kBatch], z[kBatch];
  /// The summands of eq. (4) with visibility, radiance and albedo left out, for a flat luminaire area x
  /// cos cos' / (pi r^2). Their mean is the form factor F, and L = albedo x L_e x F. Zero: no contribution,
  /// no ray needed.
  alignas(64) float form_factor[kBatch];
};

/// A way that a viewer looks along, render space: origin + t direction.
struct SightLine {
  Vec3d origin, direction;
  double t_near, t_far;
  bool blocked;  // it ends at a surface
};

/// A shape in render space that sends light, without its colour. Immutable; copies of a luminaire share it.
class Emitter {
 public:
  virtual ~Emitter() = default;

  /// It sends nothing to any point.
  virtual bool dark() const { return false; }
  /// Light comes from one point or direction: all points are the same, and one ray tells all.
  virtual bool is_point() const { return false; }
  /// It fills so much of the view that small parts of it may be hidden anywhere: a few rays prove nothing.
  virtual bool is_wide() const { return false; }

  /// No point of it is both above the surface's horizon and sending light there.
  virtual bool unseen_from(const SurfacePoint& surface) const { return form_factor(surface) <= 0; }

  /// Form factor E / (pi L_e) at a surface point where nothing hides the luminaire.
  virtual double form_factor(const SurfacePoint& surface) const = 0;
  /// The same for many surface points at once.
  virtual void form_factors(const SurfaceColumns& surfaces, double* out) const;

  /// Maps points of the unit square to the luminaire and evaluates them.
  virtual void evaluate(const SurfacePoint& surface, const float* u, const float* v, uint32_t count,
                        LightPoints& out) const = 0;
  /// Some points for each of many surface points, kBatch in sum: (u, v)[k * surfaces.count + i] is point k
  /// for surface i.
  virtual void evaluate_each(const SurfaceColumns& surfaces, const float* u, const float* v, uint32_t points,
                             LightPoints& out) const;

  /// Of a luminaire that is one, of constant radiance.
  virtual std::optional<Parallelogram> parallelogram() const { return {}; }

  /// What the line sees of the emitter itself: radiance towards its origin, in the unit of form factors. Zero
  /// for what is seen otherwise: meshes are surfaces, the sky is the background.
  virtual double seen_along(const SightLine&) const { return 0; }

  /// Its parts, if it can belong to a group of luminaires; none where its light comes from outside the scene.
  virtual std::vector<LightElement> elements() const { return {}; }
  /// Form factor of one of them, by its number.
  virtual double form_factor_of(uint32_t /*element*/, const SurfacePoint& surface) const {
    return form_factor(surface);
  }
};

/// Form factor from the centres of side x side equal cells of the unit square, where there is no closed form.
/// side: a multiple of 8.
double midpoint_form_factor(const Emitter& emitter, const SurfacePoint& surface, uint32_t side);

}  // namespace penumbra
