// SPDX-License-Identifier: GPL-3.0-or-later
// What a mesh tells about its surface beside positions and normals: UV maps, colours, generated coordinates.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "math/motion.h"
#include "scene/normalization.h"

namespace penumbra {

/// Values at each corner of each triangle, interpolated in between.
struct Attribute {
  uint32_t name;  // number of its name in the scene
  std::vector<std::array<float, 4>>
      corners;  // three a triangle; a component that is missing is 0, a fourth 1
};

/// Where on which mesh a surface point lies, as materials see it. Of the geometry that found the point, which
/// writes all of it: zeroing it first would be a tenth of what following a ray takes.
struct SurfacePlace {
  const std::vector<Attribute>* attributes;
  const Normalization* normalization;
  const Affine* render_from_object;
  const Affine* render_from_mesh;  // from the space of the edges
  Vec3d edge1, edge2;              // of the triangle
  uint32_t triangle;
  double u, v;  // barycentric weights of its second and third corner
  bool backfacing;
  // Of an instance that moves: transforms at evenly spaced times, empty where it stands still.
  const std::vector<Affine>*object_motion, *mesh_motion;
  double time;

  Affine render_from_object_now() const { return now(object_motion, *render_from_object); }
  Affine render_from_mesh_now() const { return now(mesh_motion, *render_from_mesh); }

 private:
  Affine now(const std::vector<Affine>* motion, const Affine& still) const {
    return motion ? at_time(*motion, still, time) : still;
  }
};

}  // namespace penumbra
