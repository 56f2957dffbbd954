// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/vertex_normals.h"

#include <numbers>
#include <stdexcept>
#include <string>

#include "math/arc_tangent.h"

namespace penumbra {
namespace {

/// The corners of polygon p, after a look at whether they are there.
std::span<const int32_t> corners_of(const Polygons& polygons, size_t p, size_t vertices) {
  const int64_t start = polygons.starts[p], total = polygons.totals[p];
  if (start < 0 || total < 0 || start + total > int64_t(polygons.corner_vertices.size()))
    throw std::out_of_range("polygon " + std::to_string(p) + " has corners that are not there");
  const auto corners = polygons.corner_vertices.subspan(size_t(start), size_t(total));
  for (const int32_t vertex : corners)
    if (vertex < 0 || size_t(vertex) >= vertices)
      throw std::out_of_range("polygon " + std::to_string(p) +
                              " has a vertex that is not there: " + std::to_string(vertex));
  return corners;
}

/// 0 to pi between two directions; a right angle where one has no length.
double angle(const Vec3d& a, const Vec3d& b) {
  const double sine = length(cross(a, b)), cosine = dot(a, b);
  return sine == 0 && cosine == 0 ? std::numbers::pi / 2 : angle_of(sine, cosine);
}

}  // namespace

std::vector<Vec3f> vertex_normals(std::span<const Vec3f> positions, const Polygons& polygons) {
  if (polygons.totals.size() != polygons.starts.size() || polygons.normals.size() != polygons.starts.size())
    throw std::out_of_range("polygons need as many totals and normals as starts");
  std::vector<Vec3d> sums(positions.size());
  for (size_t p = 0; p < polygons.starts.size(); ++p) {
    const auto corners = corners_of(polygons, p, positions.size());
    if (corners.empty()) continue;
    const Vec3d normal(polygons.normals[p]);
    Vec3d here(positions[size_t(corners.front())]);
    Vec3d back = Vec3d(positions[size_t(corners.back())]) - here;
    for (size_t i = 0; i < corners.size(); ++i) {
      const Vec3d next(positions[size_t(corners[i + 1 < corners.size() ? i + 1 : 0])]);
      const Vec3d ahead = next - here;
      sums[size_t(corners[i])] += normal * angle(back, ahead);
      here = next, back = -ahead;
    }
  }
  std::vector<Vec3f> normals(positions.size());
  for (size_t v = 0; v < normals.size(); ++v)
    normals[v] = Vec3f(normalize(sums[v] == Vec3d{} ? Vec3d(positions[v]) : sums[v]));
  return normals;
}

}  // namespace penumbra
