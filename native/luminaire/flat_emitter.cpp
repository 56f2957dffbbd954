// SPDX-License-Identifier: GPL-3.0-or-later
#include "luminaire/flat_emitter.h"

#include <cmath>
#include <numbers>

#include "luminaire/form_factor.h"
#include "luminaire/parallelogram.h"
#include "luminaire/unit_disk.h"
#include "math/simd.h"

namespace penumbra {
namespace {

constexpr double kPi = std::numbers::pi;

/// A part of the parallelogram: (s, t) + (width u, height v) for u, v in 0 ... 1.
struct Part {
  float s, t, width, height;
};

/// The smallest that holds all of a parallelogram that is above the surface's horizon, a + b s + c t > 0:
/// points below tell nothing, and at least half of this part is above.
inline Part part_above(double a, double b, double c) {
  const auto bound = [](double value) { return value > 0 ? (value < 1 ? value : 1.0) : 0.0; };
  // Where the other coordinate's best end is at the horizon.
  const double s = bound(-(a + (c > 0 ? c : 0)) / b), t = bound(-(a + (b > 0 ? b : 0)) / c);
  const double low_s = b > 0 ? s : 0, high_s = b < 0 ? s : 1, low_t = c > 0 ? t : 0, high_t = c < 0 ? t : 1;
  return {float(low_s), float(low_t), float(high_s - low_s), float(high_t - low_t)};
}

/// From a surface point with `surface_normal` to the luminaire's corner, then to point (u, v) of a part of
/// it: direction and cos cos' / r^2 term. A direction of no or infinite length gives 0, as do both horizons.
inline void evaluate_one(const FormFactorTerms& g, const Vec3f& corner, const Vec3f& surface_normal,
                         const Part& part, float u, float v, LightPoints& out, size_t i) {
  const float s = part.s + part.width * u, t = part.t + part.height * v;
  const float dx = corner.x + (s * g.edge_u.x + t * g.edge_v.x);
  const float dy = corner.y + (s * g.edge_u.y + t * g.edge_v.y);
  const float dz = corner.z + (s * g.edge_u.z + t * g.edge_v.z);
  const float cos_surface = dx * surface_normal.x + dy * surface_normal.y + dz * surface_normal.z;
  const float cos_light = -(dx * g.normal.x + dy * g.normal.y + dz * g.normal.z);
  const float inverse = 1.0f / (dx * dx + dy * dy + dz * dz);
  const float value = (cos_surface * inverse) * (cos_light * inverse) * g.scale * (part.width * part.height);
  out.x[i] = dx;
  out.y[i] = dy;
  out.z[i] = dz;
  // Written so that NaN and Inf (a point on the luminaire) fail the test.
  out.form_factor[i] = cos_surface > 0 && cos_light > 0 && value < 3e38f ? value : 0.0f;
}

PENUMBRA_VECTORIZED
void evaluate_from_one(const FormFactorTerms& terms, const Vec3f& corner, const Vec3f& surface_normal,
                       const Part& above, const float* u, const float* v, uint32_t count, LightPoints& out) {
  const FormFactorTerms g = terms;  // copies: `out` can't alias them
  const Vec3f from = corner, normal = surface_normal;
  const Part part = above;
  for (uint32_t i = 0; i < count; ++i) evaluate_one(g, from, normal, part, u[i], v[i], out, i);
}

PENUMBRA_VECTORIZED
void evaluate_from_each(const FormFactorTerms& terms, const Vec3d& corner, const Vec3d& edge_u,
                        const Vec3d& edge_v, const SurfaceColumns& surfaces, const float* u, const float* v,
                        uint32_t points, LightPoints& __restrict out) {
  const FormFactorTerms g = terms;
  const Vec3d c = corner, eu = edge_u, ev = edge_v;
  const size_t count = surfaces.count;
  alignas(64) float from_x[kBatch], from_y[kBatch], from_z[kBatch];
  alignas(64) float normal_x[kBatch], normal_y[kBatch], normal_z[kBatch];
  alignas(64) float s[kBatch], t[kBatch], width[kBatch], height[kBatch];
  for (size_t i = 0; i < count; ++i) {
    const Vec3d from(c.x - surfaces.x[i], c.y - surfaces.y[i], c.z - surfaces.z[i]);
    const Vec3d normal(surfaces.normal_x[i], surfaces.normal_y[i], surfaces.normal_z[i]);
    const Part part = part_above(dot(from, normal), dot(eu, normal), dot(ev, normal));
    from_x[i] = float(from.x), from_y[i] = float(from.y), from_z[i] = float(from.z);
    normal_x[i] = float(normal.x), normal_y[i] = float(normal.y), normal_z[i] = float(normal.z);
    s[i] = part.s, t[i] = part.t, width[i] = part.width, height[i] = part.height;
  }
  for (size_t first = 0; first < points * count; first += count)
    for (size_t i = 0; i < count; ++i)
      evaluate_one(g, {from_x[i], from_y[i], from_z[i]}, {normal_x[i], normal_y[i], normal_z[i]},
                   {s[i], t[i], width[i], height[i]}, u[first + i], v[first + i], out, first + i);
}

}  // namespace

double area_of(LuminaireShape shape, const Affine& world_from_light, double size_x, double size_y) {
  const double parallelogram =
      length(cross(world_from_light.x_axis * size_x, world_from_light.y_axis * size_y));
  return shape == LuminaireShape::kEllipse ? parallelogram * kPi / 4 : parallelogram;
}

FlatEmitter::FlatEmitter(const AreaLuminaire& description, const Normalization& normalization)
    : shape_(description.shape) {
  const Affine t = normalization.transform(description.world_from_light);
  edge_u_ = t.x_axis * description.size_x;
  edge_v_ = t.y_axis * description.size_y;
  corner_ = t.origin - edge_u_ * 0.5 - edge_v_ * 0.5;
  if (shape_ == LuminaireShape::kRectangle) cut_u_ = edge_u_, cut_v_ = edge_v_;
  area_ = area_of(shape_, t, description.size_x, description.size_y);
  normal_ = normalize(cross(edge_u_, edge_v_));
  // It emits towards local -z, in mirrored and sheared transforms too.
  if (dot(normal_, t.z_axis) > 0) normal_ = -normal_;
  terms_ = {Vec3f(edge_u_), Vec3f(edge_v_), Vec3f(normal_), float(area_ / kPi)};
  make_outline();
}

void FlatEmitter::make_outline() {
  if (shape_ == LuminaireShape::kRectangle) {
    vertices_ = {{}, edge_u_, edge_u_ + edge_v_, edge_v_};
    edges_ = {edge_u_, edge_v_, -edge_u_, -edge_v_};
    return;
  }
  constexpr int kSides = kMostVertices;
  // Radius of the regular polygon that has the circle's area.
  const double radius = 0.5 * std::sqrt(2 * kPi / kSides / std::sin(2 * kPi / kSides));
  const auto vertex = [&](int i) {
    const double angle = 2 * kPi * i / kSides;
    return edge_u_ * (0.5 + radius * std::cos(angle)) + edge_v_ * (0.5 + radius * std::sin(angle));
  };
  for (int i = 0; i < kSides; ++i) {
    vertices_.push_back(vertex(i));
    edges_.push_back(vertex(i + 1) - vertex(i));
  }
}

double FlatEmitter::form_factor(const SurfacePoint& surface) const {
  const Vec3d origin = corner_ - surface.position;
  if (dot(origin, normal_) >= 0) return 0;  // behind it, or in its plane
  Vec3d from_point[kMostVertices];
  for (size_t i = 0; i < vertices_.size(); ++i) from_point[i] = origin + vertices_[i];
  return polygon_form_factor({from_point, vertices_.size()}, edges_, surface.normal);
}

bool FlatEmitter::unseen_from(const SurfacePoint& surface) const {
  const Vec3d origin = corner_ - surface.position;
  if (dot(origin, normal_) >= 0) return true;
  for (const Vec3d& corner : {origin, origin + edge_u_, origin + edge_v_, origin + edge_u_ + edge_v_})
    if (dot(corner, surface.normal) > 0) return false;
  return true;
}

void FlatEmitter::form_factors(const SurfaceColumns& surfaces, double* out) const {
  polygon_form_factors(vertices_, edges_, corner_, normal_, surfaces, out);
}

std::vector<LightElement> FlatEmitter::elements() const {
  LightElement e;
  e.centre = corner_ + edge_u_ * 0.5 + edge_v_ * 0.5;
  e.normal = normal_;
  // Standard deviations of a uniform density: 1 / sqrt(12) of a rectangle's edge, 1 / 4 of an ellipse's axis.
  const double deviation = shape_ == LuminaireShape::kEllipse ? 0.25 : std::sqrt(1.0 / 12);
  e.half_u = edge_u_ * deviation;
  e.half_v = edge_v_ * deviation;
  e.strength = area_ / kPi;
  e.radius = std::max(length(edge_u_ + edge_v_), length(edge_u_ - edge_v_)) / 2;
  return {e};
}

void FlatEmitter::to_shape(const float*& u, const float*& v, uint32_t count, float* s, float* t) const {
  if (shape_ == LuminaireShape::kRectangle) return;
  square_to_disk(u, v, count, s, t);
  for (uint32_t i = 0; i < count; ++i) {  // of the parallelogram around the ellipse
    s[i] = 0.5f + 0.5f * s[i];
    t[i] = 0.5f + 0.5f * t[i];
  }
  u = s;
  v = t;
}

void FlatEmitter::evaluate(const SurfacePoint& surface, const float* u, const float* v, uint32_t count,
                           LightPoints& out) const {
  alignas(64) float s[kBatch], t[kBatch];
  to_shape(u, v, count, s, t);
  const Vec3d from = corner_ - surface.position, normal = surface.normal;  // subtracted in double
  const Part part = part_above(dot(from, normal), dot(cut_u_, normal), dot(cut_v_, normal));
  evaluate_from_one(terms_, Vec3f(from), Vec3f(normal), part, u, v, count, out);
}

void FlatEmitter::evaluate_each(const SurfaceColumns& surfaces, const float* u, const float* v,
                                uint32_t points, LightPoints& out) const {
  alignas(64) float s[kBatch], t[kBatch];
  to_shape(u, v, surfaces.count * points, s, t);
  evaluate_from_each(terms_, corner_, cut_u_, cut_v_, surfaces, u, v, points, out);
}

double FlatEmitter::seen_along(const SightLine& line) const {
  const auto place = meet_parallelogram(line, corner_, edge_u_, edge_v_, normal_);
  return place && (shape_ == LuminaireShape::kRectangle || place->in_ellipse()) ? 1 : 0;
}

}  // namespace penumbra
