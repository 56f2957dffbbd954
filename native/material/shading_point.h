// SPDX-License-Identifier: GPL-3.0-or-later
// A surface point with its closures, and how much of the light from given directions it sends to the viewer.
#pragma once

#include <cstdint>

#include "scene/closures.h"
#include "scene/surface_point.h"

namespace penumbra {

/// A surface point with its closures, seen along a ray. Of the paper's BRDF (section 3):
///   diffuse: f = albedo / pi
///   Phong:   f = albedo (n + 2) / (2 pi) cos^n(angle between the mirror direction and the light)
///   mirror:  albedo x delta in the mirror direction
/// The Phong lobe is the modified one of Lafortune and Willems 1994: its reflectance reaches the albedo at
/// normal incidence and stays below it elsewhere, so that the three albedos bound the reflected energy.
struct ShadingPoint {
  const SurfacePoint& surface;
  const Closures& material;
  Vec3d mirror_direction;  // unit; where there is a Phong lobe
  Vec3f normal, view;      // unit; `view` points to the viewer, where there are further lobes
  bool has_glossy;         // a lobe whose visible part is not Lambert's

  ShadingPoint(const SurfacePoint& s, const Closures& m, const Vec3d& ray_direction)
      : surface(s), material(m), normal(s.normal), has_glossy(m.has_glossy()) {
    if (max_component(m.phong) > 0) mirror_direction = normalize(reflect(ray_direction, s.normal));
    if (m.lobe_count > 0) view = Vec3f(normalize(-ray_direction));
  }
};

/// The glossy lobes as one weight a light point: out[i] = form_factor[i] x pi x (BRDF / albedo) of the Phong
/// lobe if it is the only one, else the largest of r, g, b of form_factor[i] x pi x BRDF, for light from
/// direction (x, y, z)[i] of any length. form_factor carries the cosines and the rest of eq. (4); where it is
/// 0 the result is. colours: gets that r, g, b, if there are other lobes than Phong's.
void evaluate_glossy(const ShadingPoint& point, const float* x, const float* y, const float* z,
                     const float* form_factor, uint32_t count, float* out, Vec3f* colours = nullptr);

/// Multiplies each form factor by the largest of r, g, b of pi x BRDF of all diffuse lobes; leaves it as it
/// is if there is Lambert's alone.
void weigh_diffuse(const ShadingPoint& point, const float* x, const float* y, const float* z, uint32_t count,
                   float* form_factor);

/// Sums over light points of form_factor x pi x BRDF, r, g, b.
struct Reflection {
  Vec3d diffuse;              // of all diffuse lobes; zero if there is Lambert's alone
  Vec3d glossy;               // of all glossy lobes; zero if there is the Phong lobe alone
  double weight = 0;          // sum of evaluate_glossy()
  double diffuse_weight = 0;  // sum of what weigh_diffuse() makes
  double form_factor = 0;     // sum

  /// Of the glossy lobes of a material, by light of 1 from each point.
  Vec3d glossy_of(const Closures& material) const {
    return material.has_glossy_lobes ? glossy : material.phong * weight;
  }
};

/// Adds at most kBatch light points to the sums.
void add_reflection(const ShadingPoint& point, const float* x, const float* y, const float* z,
                    const float* form_factor, uint32_t count, Reflection& sum);

}  // namespace penumbra
