// SPDX-License-Identifier: GPL-3.0-or-later
#include "luminaire/spread_emitter.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "luminaire/parallelogram.h"

namespace penumbra {
namespace {

/// Blender's smallest, 1 degree, is above it; below it the closed form of the peak cancels.
constexpr double kLeastHalfSpread = 0.004;

}  // namespace

SpreadEmitter::SpreadEmitter(const AreaLuminaire& description, const Normalization& normalization)
    : is_ellipse_(description.shape == LuminaireShape::kEllipse) {
  const Affine t = normalization.transform(description.world_from_light);
  edge_u_ = t.x_axis * description.size_x;
  edge_v_ = t.y_axis * description.size_y;
  corner_ = t.origin - edge_u_ * 0.5 - edge_v_ * 0.5;
  const Vec3d across = cross(edge_u_, edge_v_);
  size_ = length(across);
  normal_ = normalize(across);
  if (dot(normal_, t.z_axis) > 0) normal_ = -normal_;
  // Integral of cos (1 - tan / tangent) over the cone, relative to pi: 1 - half / tangent.
  const double half = std::max(description.spread / 2, kLeastHalfSpread);
  tangent_ = std::tan(half);
  peak_ = 1 / (1 - half / tangent_);
}

SpreadEmitter::Part SpreadEmitter::part_seen_from(const Vec3d& point) const {
  const Vec3d to_corner = corner_ - point, across = cross(edge_u_, edge_v_);
  const double height = -dot(to_corner, normal_), reach = height * tangent_;
  if (height <= 0) return {{0, 0}, {0, 0}};
  // Coordinates of the foot of the perpendicular, and how fast they change across the plane.
  const Vec3d foot = -to_corner - normal_ * height;
  const double at[2] = {dot(cross(foot, edge_v_), across) / (size_ * size_),
                        dot(cross(edge_u_, foot), across) / (size_ * size_)};
  const double slope[2] = {length(edge_v_) / size_, length(edge_u_) / size_};
  Part part;
  for (int i = 0; i < 2; ++i) {
    part.low[i] = std::max(at[i] - reach * slope[i], 0.0);
    part.high[i] = std::min(at[i] + reach * slope[i], 1.0);
  }
  return part;
}

bool SpreadEmitter::unseen_from(const SurfacePoint& surface) const {
  if (part_seen_from(surface.position).empty()) return true;
  const Vec3d origin = corner_ - surface.position;
  for (const Vec3d& corner : {origin, origin + edge_u_, origin + edge_v_, origin + edge_u_ + edge_v_})
    if (dot(corner, surface.normal) > 0) return false;
  return true;
}

double SpreadEmitter::form_factor(const SurfacePoint& surface) const {
  return unseen_from(surface) ? 0 : midpoint_form_factor(*this, surface, 32);
}

std::vector<LightElement> SpreadEmitter::elements() const {
  LightElement e;
  e.centre = corner_ + edge_u_ * 0.5 + edge_v_ * 0.5;
  e.normal = normal_;
  e.strength = size_ * peak_ / std::numbers::pi;
  e.radius = std::max(length(edge_u_ + edge_v_), length(edge_u_ - edge_v_)) / 2;
  e.near = std::numeric_limits<double>::infinity();  // the fall is not in the formula
  return {e};
}

void SpreadEmitter::evaluate(const SurfacePoint& surface, const float* u, const float* v, uint32_t count,
                             LightPoints& out) const {
  const Part part = part_seen_from(surface.position);
  const double width = part.high[0] - part.low[0], height = part.high[1] - part.low[1];
  const Vec3f origin(corner_ - surface.position + edge_u_ * part.low[0] + edge_v_ * part.low[1]);
  const Vec3f edge_u(edge_u_ * width), edge_v(edge_v_ * height), n(surface.normal), l(normal_);
  const auto scale = part.empty() ? 0.0f : float(size_ * width * height * peak_ / std::numbers::pi);
  const auto cotangent = float(1 / tangent_);
  for (uint32_t i = 0; i < count; ++i) {
    const Vec3f d = origin + (edge_u * u[i] + edge_v * v[i]);
    const float cos_surface = dot(d, n), cos_light = -dot(d, l), square = dot(d, d), inverse = 1 / square;
    const float sine = std::sqrt(std::max(square - cos_light * cos_light, 0.0f));
    const float fall = 1 - sine / cos_light * cotangent;
    const auto s = float(part.low[0] + width * double(u[i])) - 0.5f,
               t = float(part.low[1] + height * double(v[i])) - 0.5f;
    const bool inside = !is_ellipse_ || s * s + t * t <= 0.25f;
    const float value = (cos_surface * inverse) * (cos_light * inverse) * fall * scale;
    out.x[i] = d.x;
    out.y[i] = d.y;
    out.z[i] = d.z;
    out.form_factor[i] =
        inside && cos_surface > 0 && cos_light > 0 && fall > 0 && value < 3e38f ? value : 0.0f;
  }
}

double SpreadEmitter::seen_along(const SightLine& line) const {
  const auto place = meet_parallelogram(line, corner_, edge_u_, edge_v_, normal_);
  if (!place || (is_ellipse_ && !place->in_ellipse())) return 0;
  const double cosine = -dot(normalize(line.direction), normal_);
  return peak_ * std::max(0.0, 1 - std::sqrt(std::max(1 - cosine * cosine, 0.0)) / (cosine * tangent_));
}

}  // namespace penumbra
