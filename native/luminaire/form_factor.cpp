// SPDX-License-Identifier: GPL-3.0-or-later
#include "luminaire/form_factor.h"

#include <cmath>
#include <numbers>

namespace penumbra {

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

}  // namespace penumbra
