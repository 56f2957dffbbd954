// SPDX-License-Identifier: GPL-3.0-or-later
#include "luminaire/form_factor.h"

#include <cmath>
#include <numbers>

#include "math/arc_tangent.h"
#include "math/simd.h"

namespace penumbra {
namespace {

/// Lambert's sum over the edges of a polygon as if no part were below the horizon, and the least height of a
/// vertex above it.
PENUMBRA_VECTORIZED
void lambert_sums(const Vec3d* vertices, const Vec3d* edges, size_t sides, const Vec3d& corner,
                  const SurfaceColumns& points, double* sums, double* heights) {
  for (uint32_t i = 0; i < points.count; ++i) {
    sums[i] = 0;
    heights[i] = 1e300;
  }
  for (size_t k = 0; k < sides; ++k) {
    const Vec3d e = edges[k], vertex = corner + vertices[k];
    for (uint32_t i = 0; i < points.count; ++i) {
      const double nx = points.normal_x[i], ny = points.normal_y[i], nz = points.normal_z[i];
      const double ax = vertex.x - points.x[i], ay = vertex.y - points.y[i], az = vertex.z - points.z[i];
      const double cx = ay * e.z - az * e.y, cy = az * e.x - ax * e.z, cz = ax * e.y - ay * e.x;
      const double sine = std::sqrt(cx * cx + cy * cy + cz * cz);
      const double cosine = ax * (ax + e.x) + ay * (ay + e.y) + az * (az + e.z);
      const double along = nx * cx + ny * cy + nz * cz, height = nx * ax + ny * ay + nz * az;
      const double term = angle_of(sine, cosine) / sine * along;
      sums[i] += sine > 0 ? term : 0.0;
      heights[i] = height < heights[i] ? height : heights[i];
    }
  }
}

}  // namespace

double polygon_form_factor(std::span<const Vec3d> vertices, std::span<const Vec3d> edges,
                           const Vec3d& normal) {
  // Clipped to the horizon (Sutherland and Hodgman): a convex polygon gains at most one vertex.
  Vec3d a[kMostVertices + 1], edge[kMostVertices + 1];
  size_t n = 0;
  bool leaves = false;
  for (size_t i = 0; i < vertices.size(); ++i) {
    const Vec3d& p = vertices[i];
    const Vec3d& q = vertices[(i + 1) % vertices.size()];
    const double height = dot(p, normal), step = dot(edges[i], normal), next = dot(q, normal);
    if (height >= 0) {
      a[n] = p;
      edge[n++] = next >= 0 ? edges[i] : edges[i] * (height / -step);
      if (next < 0) {  // down through the horizon: the next edge runs along it
        a[n] = p + edge[n - 1];
        ++n;
        leaves = true;
      }
    } else if (next >= 0 && step > 0) {  // up through it
      const double cut = -height / step;
      a[n] = p + edges[i] * cut;
      edge[n++] = edges[i] * (1 - cut);
    }
  }
  if (n < 3) return 0;
  if (leaves)
    for (size_t i = 0; i < n; ++i)
      if (edge[i] == Vec3d{}) edge[i] = a[(i + 1) % n] - a[i];

  double sum = 0;
  for (size_t i = 0; i < n; ++i) {
    const Vec3d c = cross(a[i], edge[i]);
    const double sine = length(c), cosine = dot(a[i], a[i] + edge[i]);
    if (sine > 0) sum += std::atan2(sine, cosine) * dot(normal, c) / sine;
  }
  return std::abs(sum) / (2 * std::numbers::pi);
}

void polygon_form_factors(std::span<const Vec3d> vertices, std::span<const Vec3d> edges, const Vec3d& corner,
                          const Vec3d& facing, const SurfaceColumns& points, double* out) {
  alignas(64) double sums[kBatch], heights[kBatch];
  lambert_sums(vertices.data(), edges.data(), vertices.size(), corner, points, sums, heights);
  for (uint32_t i = 0; i < points.count; ++i) {
    const Vec3d origin = corner - Vec3d{points.x[i], points.y[i], points.z[i]};
    out[i] = 0;
    if (dot(origin, facing) >= 0) continue;  // behind it, or in its plane
    out[i] = std::abs(sums[i]) / (2 * std::numbers::pi);
    if (heights[i] >= 0) continue;
    Vec3d from_point[kMostVertices];
    for (size_t k = 0; k < vertices.size(); ++k) from_point[k] = origin + vertices[k];
    out[i] = polygon_form_factor({from_point, vertices.size()}, edges,
                                 {points.normal_x[i], points.normal_y[i], points.normal_z[i]});
  }
}

}  // namespace penumbra
