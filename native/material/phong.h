// SPDX-License-Identifier: GPL-3.0-or-later
// The paper's BRDF at a point: mirror + Phong specular + ideal diffuse (section 3).
#pragma once

#include <cstdint>

#include "math/vector.h"
#include "scene/scene.h"
#include "scene/surface_point.h"

namespace penumbra {

/// A surface point with its material, seen along a ray.
///   diffuse: f = albedo / pi
///   Phong:   f = albedo (n + 2) / (2 pi) cos^n(angle between the mirror direction and the light)
///   mirror:  albedo x delta in the mirror direction
/// The Phong lobe is the modified one of Lafortune and Willems 1994: its reflectance reaches the albedo at
/// normal incidence and stays below it elsewhere, so that the three albedos bound the reflected energy.
struct ShadingPoint {
  const SurfacePoint& surface;
  const Material& material;
  Vec3d mirror_direction;  // unit
  bool has_phong;

  ShadingPoint(const SurfacePoint& s, const Material& m, const Vec3d& ray_direction)
      : surface(s),
        material(m),
        mirror_direction(normalize(reflect(ray_direction, s.normal))),
        has_phong(max_component(m.phong) > 0) {}
};

/// out[i] = form_factor[i] x (Phong BRDF / its albedo) x pi, for light from direction (x, y, z)[i] of any
/// length. form_factor carries the cosines and the rest of eq. (4); where it is 0 the result is.
void evaluate_phong(const ShadingPoint& point, const float* x, const float* y, const float* z,
                    const float* form_factor, uint32_t count, float* out);

}  // namespace penumbra
