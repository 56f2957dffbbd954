// SPDX-License-Identifier: GPL-3.0-or-later
#include "luminaire/sun_emitter.h"

#include <algorithm>
#include <cmath>

namespace penumbra {
namespace {

/// Of the half angle: below it single-precision directions could not tell the disk's points apart.
constexpr double kSmallestSine = 0x1p-24;

}  // namespace

SunEmitter::SunEmitter(const SunLuminaire& description)
    : cone_{normalize(description.to_sun), std::pow(std::sin(description.half_angle), 2)} {
  if (cone_.sine_squared < kSmallestSine * kSmallestSine) cone_.sine_squared = 0;
}

double SunEmitter::form_factor(const SurfacePoint& surface) const {
  if (is_point()) return std::max(dot(surface.normal, cone_.axis), 0.0);
  return cone_.form_factor(surface.normal) / cone_.sine_squared;
}

void SunEmitter::evaluate(const SurfacePoint& surface, const float* u, const float* v, uint32_t count,
                          LightPoints& out) const {
  if (is_point()) {
    const Vec3f d(cone_.axis * double(kBeyondScene));
    std::fill(out.x, out.x + count, d.x);
    std::fill(out.y, out.y + count, d.y);
    std::fill(out.z, out.z + count, d.z);
    std::fill(out.form_factor, out.form_factor + count, float(form_factor(surface)));
    return;
  }
  evaluate_cone(cone_, ConeDepth::kDistant, 0, surface.normal, u, v, count, out);
  for (uint32_t i = 0; i < count; ++i) out.form_factor[i] /= float(cone_.sine_squared);
}

double SunEmitter::seen_along(const SightLine& line) const {
  if (line.blocked || is_point() || dot(line.direction, cone_.axis) <= 0) return 0;
  const Vec3d across = cross(line.direction, cone_.axis);
  return dot(across, across) <= cone_.sine_squared * dot(line.direction, line.direction)
             ? 1 / cone_.sine_squared
             : 0;
}

}  // namespace penumbra
