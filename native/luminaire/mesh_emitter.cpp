// SPDX-License-Identifier: GPL-3.0-or-later
#include "luminaire/mesh_emitter.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "luminaire/form_factor.h"
#include "luminaire/mesh_order.h"
#include "math/simd.h"

namespace penumbra {
namespace {

constexpr double kPi = std::numbers::pi;

/// A triangle is far if its longest edge is below this share of the distance; then three points tell its form
/// factor to (1/6)^4.
constexpr float kFar = 1.0f / 6;

/// Light points lie this much before their triangle, relative to the coordinates: more than Embree's rounding
/// (visibility/geometry.cpp), so that the triangle and its neighbours do not hide them.
constexpr float kInFront = 0x1p-19f;

/// Columns of the loop over triangles: corners relative to the bounds' centre, the normal times area x weight
/// / 3, and the least distance squared from which it is far.
enum Column { kA, kB = 3, kC = 6, kNormal = 9, kFarSquare = 12, kColumns = 13 };

constexpr uint32_t kLane = 64;

struct FarTerms {
  Vec3f point, normal;
  bool one_sided;
};

/// Triangles [first, first + kLane): the form factors of those that are far and wholly above the horizon;
/// exact[i] is 1 where the closed form is needed.
PENUMBRA_VECTORIZED
void far_form_factors(const std::vector<float>* columns, size_t first, const FarTerms& terms, float* out,
                      int* exact) {
  const FarTerms g = terms;
  const float* c[kColumns];
  for (int k = 0; k < kColumns; ++k) c[k] = columns[k].data() + first;
  for (uint32_t i = 0; i < kLane; ++i) {
    const float ax = c[0][i] - g.point.x, ay = c[1][i] - g.point.y, az = c[2][i] - g.point.z;
    const float bx = c[3][i] - g.point.x, by = c[4][i] - g.point.y, bz = c[5][i] - g.point.z;
    const float cx = c[6][i] - g.point.x, cy = c[7][i] - g.point.y, cz = c[8][i] - g.point.z;
    const float nx = c[9][i], ny = c[10][i], nz = c[11][i];
    const float ha = ax * g.normal.x + ay * g.normal.y + az * g.normal.z;
    const float hb = bx * g.normal.x + by * g.normal.y + bz * g.normal.z;
    const float hc = cx * g.normal.x + cy * g.normal.y + cz * g.normal.z;
    const float side = -(ax * nx + ay * ny + az * nz);  // the same for all of its points
    // Edge midpoints: exact for polynomials of degree 2.
    const auto at = [&](float x, float y, float z, float height) {
      const float square = x * x + y * y + z * z;
      return height / (square * square);
    };
    const float sum = at(0.5f * (ax + bx), 0.5f * (ay + by), 0.5f * (az + bz), 0.5f * (ha + hb)) +
                      at(0.5f * (bx + cx), 0.5f * (by + cy), 0.5f * (bz + cz), 0.5f * (hb + hc)) +
                      at(0.5f * (cx + ax), 0.5f * (cy + ay), 0.5f * (cz + az), 0.5f * (hc + ha));
    const bool sends = g.one_sided ? side > 0 : side != 0;
    const bool above = ha >= 0 && hb >= 0 && hc >= 0, below = ha <= 0 && hb <= 0 && hc <= 0;
    const bool far = ax * ax + ay * ay + az * az >= c[12][i];
    out[i] = sends && above && far ? sum * std::abs(side) : 0.0f;
    exact[i] = sends && !below && !(above && far);
  }
}

}  // namespace

MeshEmitter::MeshEmitter(const MeshLuminaire& description, const Normalization& normalization)
    : closed_(description.weights.empty() && is_closed(description.triangles)),
      one_sided_(description.one_sided) {
  std::vector<Vec3d> positions;
  for (const Vec3d& p : description.positions) positions.push_back(normalization.point(p));
  for (const auto& corners : description.triangles)
    for (uint32_t corner : corners) bounds_.include(positions[corner]);
  std::vector<double> areas;
  const auto triangles = closed_ ? outward(description.triangles, positions) : description.triangles;
  for (const size_t i : curve_order(triangles, positions, bounds_)) {
    const auto& corners = triangles[i];
    Triangle t;
    t.weight = description.weights.empty() ? 1 : double(description.weights[i]);
    t.corner = positions[corners[0]];
    t.edge1 = positions[corners[1]] - t.corner;
    t.edge2 = positions[corners[2]] - t.corner;
    const Vec3d normal = cross(t.edge1, t.edge2);
    const double area = length(normal) / 2;
    if (!(area * t.weight > 0)) continue;
    t.normal = normal / (2 * area);
    triangles_.push_back(t);
    areas.push_back(area * t.weight);
    power_ += area * t.weight;
  }
  double part = 0;
  for (double area : areas) {
    cumulative_.push_back(float(part / power_));
    part += area;
  }
  cumulative_.push_back(1);

  const size_t padded = (triangles_.size() + kLane - 1) / kLane * kLane;
  for (int k = 0; k < kColumns; ++k) columns_[k].assign(padded, 0.0f);  // padding sends nothing: no normal
  for (size_t i = 0; i < triangles_.size(); ++i) {
    const Triangle& t = triangles_[i];
    const Vec3d a = t.corner - bounds_.centre(), b = a + t.edge1, c = a + t.edge2;
    const Vec3d n = t.normal * (areas[i] / (3 * kPi));
    for (int axis = 0; axis < 3; ++axis) {
      columns_[kA + axis][i] = float(a[axis]);
      columns_[kB + axis][i] = float(b[axis]);
      columns_[kC + axis][i] = float(c[axis]);
      columns_[kNormal + axis][i] = float(n[axis]);
    }
    const Vec3d edge3 = t.edge2 - t.edge1;
    const double longest = std::max({dot(t.edge1, t.edge1), dot(t.edge2, t.edge2), dot(edge3, edge3)});
    columns_[kFarSquare][i] = float(longest) / (kFar * kFar);
  }
}

bool MeshEmitter::one_sided_from(const Vec3d& p) const {
  const Vec3d low = bounds_.low, high = bounds_.high;
  if (one_sided_) return true;
  return closed_ &&
         (p.x < low.x || p.y < low.y || p.z < low.z || p.x > high.x || p.y > high.y || p.z > high.z);
}

bool MeshEmitter::unseen_from(const SurfacePoint& surface) const {
  for (const Vec3d& corner : bounds_.corners())
    if (dot(corner - surface.position, surface.normal) > 0) return false;
  return true;
}

double MeshEmitter::triangle_form_factor(const Triangle& t, const SurfacePoint& surface) const {
  const Vec3d a = t.corner - surface.position;
  const Vec3d vertices[3] = {a, a + t.edge1, a + t.edge2};
  const Vec3d edges[3] = {t.edge1, t.edge2 - t.edge1, -t.edge2};
  return t.weight * polygon_form_factor(vertices, edges, surface.normal);
}

double MeshEmitter::form_factor(const SurfacePoint& surface) const {
  if (unseen_from(surface)) return 0;
  const FarTerms terms{Vec3f(surface.position - bounds_.centre()), Vec3f(surface.normal),
                       one_sided_from(surface.position)};
  alignas(64) float far[kLane];
  alignas(64) int exact[kLane];
  double sum = 0;
  for (size_t first = 0; first < triangles_.size(); first += kLane) {
    far_form_factors(columns_, first, terms, far, exact);
    // Padding may be near, too, where a surface is at no finite place.
    const size_t count = std::min<size_t>(kLane, triangles_.size() - first);
    for (size_t i = 0; i < count; ++i)
      sum += exact[i] ? triangle_form_factor(triangles_[first + i], surface) : double(far[i]);
  }
  return sum;
}

std::vector<LightElement> MeshEmitter::elements() const {
  std::vector<LightElement> elements;
  for (size_t i = 0; i < triangles_.size(); ++i) {
    const Triangle& t = triangles_[i];
    LightElement e;
    e.centre = t.corner + (t.edge1 + t.edge2) / 3;
    e.normal = t.normal;
    // Second moments of a triangle: (edge1 edge1' + edge2 edge2' - (edge1 edge2' + edge2 edge1') / 2) / 18,
    // taken apart by completing the square.
    e.half_u = (t.edge1 - t.edge2 * 0.5) / std::sqrt(18.0);
    e.half_v = t.edge2 * std::sqrt(0.75 / 18);
    e.strength = t.weight * length(cross(t.edge1, t.edge2)) / (2 * kPi);
    const Vec3d to_corner = t.corner - e.centre;
    e.radius = std::max({length(to_corner), length(to_corner + t.edge1), length(to_corner + t.edge2)});
    e.two_sided = !closed_ && !one_sided_;
    e.two_sided_near = !one_sided_;
    if (closed_) {  // one-sided from outside the bounding box
      for (const Vec3d& corner : bounds_.corners()) e.near = std::max(e.near, length(corner - e.centre));
    }
    e.u_begin = cumulative_[i];
    e.u_end = cumulative_[i + 1];
    elements.push_back(e);
  }
  return elements;
}

double MeshEmitter::form_factor_of(uint32_t element, const SurfacePoint& surface) const {
  const Triangle& t = triangles_[element];
  const double side = dot(surface.position - t.corner, t.normal);
  if (side == 0 || (side < 0 && one_sided_from(surface.position))) return 0;
  return triangle_form_factor(t, surface);
}

void MeshEmitter::evaluate(const SurfacePoint& surface, const float* u, const float* v, uint32_t count,
                           LightPoints& out) const {
  const Vec3f n(surface.normal);
  const bool one_sided = one_sided_from(surface.position);
  const auto scale = float(power_ / kPi);
  const float in_front = kInFront * float(max_abs(bounds_.centre()) + max_abs(bounds_.extent()));
  for (uint32_t i = 0; i < count; ++i) {
    const auto above = std::upper_bound(cumulative_.begin() + 1, cumulative_.end() - 1, u[i]);
    const auto k = size_t(above - cumulative_.begin()) - 1;
    const Triangle& t = triangles_[k];
    const float width = cumulative_[k + 1] - cumulative_[k];
    const float within = width > 0 ? std::clamp((u[i] - cumulative_[k]) / width, 0.0f, 1.0f) : 0.5f;
    // Unit square to triangle, uniformly in area (Turk 1990).
    const float root = std::sqrt(within), s = root * (1 - v[i]), r = root * v[i];
    const Vec3f normal(t.normal);
    Vec3f d = Vec3f(t.corner - surface.position) + (Vec3f(t.edge1) * s + Vec3f(t.edge2) * r);
    const float side = -dot(d, normal);
    d += normal * (side > 0 ? in_front : -in_front);
    const float cos_surface = dot(d, n), cos_light = one_sided ? side : std::abs(side);
    const float inverse = 1 / dot(d, d);
    const float value = (cos_surface * inverse) * (cos_light * inverse) * scale;
    out.x[i] = d.x;
    out.y[i] = d.y;
    out.z[i] = d.z;
    out.form_factor[i] = cos_surface > 0 && cos_light > 0 && value < 3e38f ? value : 0.0f;
  }
}

}  // namespace penumbra
