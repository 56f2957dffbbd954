// SPDX-License-Identifier: GPL-3.0-or-later
#include "luminaire/point_emitter.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "luminaire/parallelogram.h"

namespace penumbra {
namespace {

constexpr double kPi = std::numbers::pi;
/// Half an ulp of coordinates near 1: below it shadow rays could not tell the points of a luminaire apart.
constexpr double kSmallestRadius = 0x1p-24;
/// A cone's edge of no width, as steep as single precision allows.
constexpr double kSteepest = 1e30;
/// Distance in radii from which a facing disk is as good as a point, to 1e-3.
constexpr double kFarDisk = 32;

double smoothstep(double x) {
  x = std::clamp(x, 0.0, 1.0);
  return x * x * (3 - 2 * x);
}

}  // namespace

PointEmitter::PointEmitter(const PointLuminaire& description, const Normalization& normalization)
    : shape_(description.shape),
      centre_(normalization.point(description.world_from_light.origin)),
      radius_(description.radius * normalization.scale) {
  if (radius_ < kSmallestRadius) radius_ = 0;
  if (radius_ > 0) per_radiance_ = 1 / (kPi * radius_ * radius_);
  if (!description.spot) return;
  const Affine& t = description.world_from_light;
  const double cos_half = std::cos(description.spot->angle / 2);
  const double width = (1 - cos_half) * description.spot->blend;
  const double size = dot(t.z_axis, t.z_axis), rounding = 1e-6 * size;
  const bool rigid =
      std::abs(dot(t.x_axis, t.x_axis) - size) < rounding &&
      std::abs(dot(t.y_axis, t.y_axis) - size) < rounding && std::abs(dot(t.x_axis, t.y_axis)) < rounding &&
      std::abs(dot(t.y_axis, t.z_axis)) < rounding && std::abs(dot(t.z_axis, t.x_axis)) < rounding;
  spot_ = Spot{t, cos_half, std::min(1 / width, kSteepest), description.spot->cosine_falloff, rigid};
}

double PointEmitter::Spot::attenuation(const Vec3d& direction) const {
  const double cosine = -normalize(axes.inverse_vector(direction)).z;
  const double full = smoothstep((cosine - cos_half) * inverse_width);
  return cosine_falloff ? full * std::max(cosine, 0.0) : full;
}

void PointEmitter::Spot::attenuate(uint32_t count, LightPoints& points) const {
  for (uint32_t i = 0; i < count; ++i)
    if (points.form_factor[i] > 0)
      points.form_factor[i] *=
          float(attenuation({-double(points.x[i]), -double(points.y[i]), -double(points.z[i])}));
}

PointEmitter::View PointEmitter::view_from(const SurfacePoint& surface) const {
  View view;
  view.to_centre = centre_ - surface.position;
  const double square = dot(view.to_centre, view.to_centre), radius_square = radius_ * radius_;
  view.distance = std::sqrt(square);
  view.inside = shape_ == RoundShape::kSphere && radius_ > 0 && square <= radius_square;
  view.cone.axis = normalize(view.to_centre);
  view.cone.sine_squared =
      view.inside ? 1 : radius_square / (shape_ == RoundShape::kSphere ? square : square + radius_square);
  return view;
}

bool PointEmitter::unseen_from(const SurfacePoint& surface) const {
  const View view = view_from(surface);
  if (view.inside) return false;
  if (view.distance == 0 || dot(surface.normal, view.cone.axis) <= -std::sqrt(view.cone.sine_squared))
    return true;
  if (!spot_) return false;
  if (radius_ == 0) return spot_->attenuation(-view.to_centre) <= 0;
  return spot_form_factor(view, surface.normal) == 0.0;
}

double PointEmitter::form_factor(const SurfacePoint& surface) const {
  const View view = view_from(surface);
  if (view.inside) return per_radiance_;
  if (view.distance == 0) return 0;
  const double cosine = dot(surface.normal, view.cone.axis);
  if (radius_ == 0) {
    const double value = cosine / (kPi * view.distance * view.distance);
    if (!(value > 0) || value > double(std::numeric_limits<float>::max())) return 0;
    return spot_ ? value * spot_->attenuation(-view.to_centre) : value;
  }
  if (!spot_) return view.cone.form_factor(surface.normal) * per_radiance_;
  if (const auto known = spot_form_factor(view, surface.normal)) return *known;
  // Where the cone's edge is not much wider than the luminaire looks, the integrand is nearly a step.
  const double width = 1 / spot_->inverse_width,
               edge_slope = std::sqrt(1 - spot_->cos_half * spot_->cos_half);
  const bool gentle = 4 * std::sqrt(view.cone.sine_squared) * edge_slope < width;
  return midpoint_form_factor(*this, surface, gentle ? 16 : 64);
}

std::optional<double> PointEmitter::spot_form_factor(const View& view, const Vec3d& normal) const {
  if (!spot_->rigid) return std::nullopt;
  const Vec3d forward = -normalize(spot_->axes.z_axis);
  const double middle = std::acos(std::clamp(-dot(forward, view.cone.axis), -1.0, 1.0));
  const double half = std::asin(std::sqrt(view.cone.sine_squared));
  const double full_at = std::acos(std::min(spot_->cos_half + 1 / spot_->inverse_width, 1.0));
  if (middle - half >= std::acos(spot_->cos_half)) return 0;
  if (middle + half >= full_at) return std::nullopt;
  if (!spot_->cosine_falloff) return view.cone.form_factor(normal) * per_radiance_;
  if (view.cone.cut_by(normal)) return std::nullopt;
  // Integral of (normal . w) (-forward . w) over the cone, by its second moments along the axis and across.
  const double solid_angle = view.cone.solid_angle(), cosine = 1 - view.cone.one_minus_cosine();
  const double along = 2 * kPi / 3 * (1 - cosine * cosine * cosine), across = (solid_angle - along) / 2;
  const double n = dot(normal, view.cone.axis), f = -dot(forward, view.cone.axis);
  return (across * (-dot(normal, forward) - n * f) + along * n * f) / kPi * per_radiance_;
}

std::vector<LightElement> PointEmitter::elements() const {
  LightElement e;
  e.centre = centre_;
  e.strength = 1 / kPi;
  // A sphere wholly above the horizon counts as its centre, a facing disk nearly so: error (radius / r)^2.
  e.radius = radius_;
  e.near = shape_ == RoundShape::kSphere ? radius_ : radius_ * kFarDisk;
  if (spot_) e.near = std::numeric_limits<double>::infinity();  // the cone is not in the formula
  return {e};
}

void PointEmitter::evaluate(const SurfacePoint& surface, const float* u, const float* v, uint32_t count,
                            LightPoints& out) const {
  const View view = view_from(surface);
  if (radius_ == 0) {
    const Vec3f d(view.to_centre);
    std::fill(out.x, out.x + count, d.x);
    std::fill(out.y, out.y + count, d.y);
    std::fill(out.z, out.z + count, d.z);
    std::fill(out.form_factor, out.form_factor + count, float(form_factor(surface)));
    return;
  }
  if (view.inside) {
    evaluate_hemisphere(surface.normal, u, v, count, out);
    for (uint32_t i = 0; i < count; ++i) {
      const double along = dot(view.to_centre, {double(out.x[i]), double(out.y[i]), double(out.z[i])});
      const double root = along * along + radius_ * radius_ - view.distance * view.distance;
      const auto length = float(along + std::sqrt(std::max(root, 0.0)));
      out.x[i] *= length;
      out.y[i] *= length;
      out.z[i] *= length;
    }
  } else {
    evaluate_cone(view.cone, shape_ == RoundShape::kSphere ? ConeDepth::kSphere : ConeDepth::kDisk,
                  view.distance, surface.normal, u, v, count, out);
    if (spot_) spot_->attenuate(count, out);
  }
  for (uint32_t i = 0; i < count; ++i) out.form_factor[i] *= float(per_radiance_);
}

double PointEmitter::seen_along(const SightLine& line) const {
  if (radius_ == 0) return 0;
  const Vec3d to_centre = centre_ - line.origin, direction = normalize(line.direction);
  const double along = dot(to_centre, direction), square = dot(to_centre, to_centre);
  double distance = 0;
  if (shape_ == RoundShape::kSphere) {
    const double root = radius_ * radius_ - (square - along * along);
    if (root < 0) return 0;
    distance = square > radius_ * radius_ ? along - std::sqrt(root) : along + std::sqrt(root);
  } else {
    if (!(along > 0)) return 0;
    distance = square / along;  // to the disk's plane
    if (distance * distance - square > radius_ * radius_) return 0;
  }
  if (!is_before_end(line, distance / length(line.direction))) return 0;
  return per_radiance_ * (spot_ ? spot_->attenuation(-direction) : 1);
}

}  // namespace penumbra
