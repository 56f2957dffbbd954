// SPDX-License-Identifier: GPL-3.0-or-later
#include "luminaire/cone.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "luminaire/unit_disk.h"
#include "math/simd.h"

namespace penumbra {
namespace {

constexpr double kPi = std::numbers::pi;

struct ConeTerms {
  float axis[3], side[3], up[3], normal[3];
  float one_minus_cosine, inverse_sine_squared;
  float weight;            // solid angle / pi
  float distance, radius;  // of the centre, of the sphere
};

/// s, t: points of the unit disk. A point at the radius r of the disk has 1 - cos = r^2 (1 - cos of the half
/// angle), which makes equal areas equal solid angles; its sine follows without cancellation.
template <ConeDepth depth>
PENUMBRA_VECTORIZED void evaluate_terms(const ConeTerms& g, const float* s, const float* t, uint32_t count,
                                        LightPoints& out) {
  for (uint32_t i = 0; i < count; ++i) {
    const float square = s[i] * s[i] + t[i] * t[i], drop = square * g.one_minus_cosine, along = 1 - drop;
    const float stretch = std::sqrt(g.one_minus_cosine * (2 - drop));
    const float a = s[i] * stretch, b = t[i] * stretch;
    const float dx = along * g.axis[0] + (a * g.side[0] + b * g.up[0]);
    const float dy = along * g.axis[1] + (a * g.side[1] + b * g.up[1]);
    const float dz = along * g.axis[2] + (a * g.side[2] + b * g.up[2]);
    const float cosine = dx * g.normal[0] + dy * g.normal[1] + dz * g.normal[2];
    float length = kBeyondScene;
    if constexpr (depth == ConeDepth::kDisk) length = g.distance / along;
    if constexpr (depth == ConeDepth::kSphere) {
      const float inside = 1 - (a * a + b * b) * g.inverse_sine_squared;
      length = g.distance * along - g.radius * std::sqrt(inside > 0 ? inside : 0.0f);
    }
    out.x[i] = dx * length;
    out.y[i] = dy * length;
    out.z[i] = dz * length;
    out.form_factor[i] = cosine > 0 && length > 0 ? cosine * g.weight : 0.0f;
  }
}

}  // namespace

double Cone::one_minus_cosine() const {
  return sine_squared / (1 + std::sqrt(1 - sine_squared));
}

double Cone::solid_angle() const {
  return 2 * kPi * one_minus_cosine();
}

bool Cone::cut_by(const Vec3d& normal) const {
  return dot(normal, axis) < std::sqrt(sine_squared);
}

/// Unclipped: sin^2 cos. Clipped: Snyder, "Area light sources for real-time graphics" (1996), in the form of
/// Lagarde and de Rousiers (2014).
double Cone::form_factor(const Vec3d& normal) const {
  const double cosine = std::clamp(dot(normal, axis), -1.0, 1.0), sine = std::sqrt(sine_squared);
  if (cosine >= sine) return sine_squared * cosine;
  if (cosine <= -sine) return 0;
  const double across = std::sqrt(1 - cosine * cosine);  // positive: the axis is near the horizon
  const double cotangent = std::sqrt(1 - sine_squared) / sine;
  const double y = std::clamp(-cotangent * cosine / across, -1.0, 1.0), rest = across * std::sqrt(1 - y * y);
  const double sum = (cosine * std::acos(y) - cotangent * rest) * sine_squared + std::atan2(rest, cotangent);
  return std::max(sum / kPi, 0.0);
}

void evaluate_cone(const Cone& cone, ConeDepth depth, double distance, const Vec3d& normal, const float* u,
                   const float* v, uint32_t count, LightPoints& out) {
  alignas(64) float s[kBatch], t[kBatch];
  square_to_disk(u, v, count, s, t);
  const Across across(cone.axis);
  const Vec3f axis(cone.axis), side(across.side), up(across.up), n(normal);
  const ConeTerms terms{{axis.x, axis.y, axis.z},
                        {side.x, side.y, side.z},
                        {up.x, up.y, up.z},
                        {n.x, n.y, n.z},
                        float(cone.one_minus_cosine()),
                        float(1 / cone.sine_squared),
                        float(cone.solid_angle() / kPi),
                        float(distance),
                        float(distance * std::sqrt(cone.sine_squared))};
  switch (depth) {
    case ConeDepth::kSphere:
      return evaluate_terms<ConeDepth::kSphere>(terms, s, t, count, out);
    case ConeDepth::kDisk:
      return evaluate_terms<ConeDepth::kDisk>(terms, s, t, count, out);
    case ConeDepth::kDistant:
      return evaluate_terms<ConeDepth::kDistant>(terms, s, t, count, out);
  }
}

void evaluate_hemisphere(const Vec3d& normal, const float* u, const float* v, uint32_t count,
                         LightPoints& out) {
  alignas(64) float s[kBatch], t[kBatch];
  square_to_disk(u, v, count, s, t);
  const Across across(normal);
  const Vec3f n(normal), side(across.side), up(across.up);
  for (uint32_t i = 0; i < count; ++i) {
    const float square = 1 - (s[i] * s[i] + t[i] * t[i]);
    const Vec3f d = n * std::sqrt(square > 0 ? square : 0.0f) + side * s[i] + up * t[i];
    out.x[i] = d.x;
    out.y[i] = d.y;
    out.z[i] = d.z;
    out.form_factor[i] = 1;
  }
}

}  // namespace penumbra
