// SPDX-License-Identifier: GPL-3.0-or-later
// Geometry for the tests of rays and lighting, from plain lists of triangles.
#pragma once

#include <initializer_list>
#include <utility>

#include "visibility/geometry.h"

namespace penumbra::test {

/// A parallelogram of two triangles.
inline Mesh quad(const Vec3d& corner, const Vec3d& u, const Vec3d& v) {
  Mesh m;
  m.name = "quad";
  m.positions = {corner, corner + u, corner + u + v, corner + v};
  m.triangles = {{0, 1, 2}, {0, 2, 3}};
  return m;
}

/// Every mesh once, at its place, with material 0.
inline Geometry place(std::vector<Mesh> meshes) {
  std::vector<Instance> instances;
  for (size_t i = 0; i < meshes.size(); ++i)
    instances.push_back({"object " + std::to_string(i), uint32_t(i), {}, {0}});
  return Geometry(std::move(meshes), std::move(instances));
}

/// The first surface that a world-space ray meets within 1e6 of its direction's length; asserts by `found`.
inline bool first_surface(const Geometry& geometry, const Vec3d& origin, const Vec3d& direction,
                          SurfacePoint& out) {
  const Normalization& n = geometry.normalization();
  const Ray ray{n.point(origin), direction * n.scale, 0, 1e6};
  Hit hit;
  geometry.intersect(&ray, 1, &hit);
  if (!hit.found()) return false;
  PlacedPoint placed;
  geometry.surface_point(ray, hit, placed);
  out = placed;
  return true;
}

}  // namespace penumbra::test
