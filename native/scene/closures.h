// SPDX-License-Identifier: GPL-3.0-or-later
// How a surface scatters and emits light at one point.
#pragma once

#include <array>
#include <cstdint>

#include "math/vector.h"

namespace penumbra {

enum class LobeKind : uint8_t {
  kLambert,        // of a bumped surface; a smooth one has Closures::diffuse
  kOrenNayar,      // rough diffuse
  kDisney,         // diffuse with retro-reflection: the Principled BSDF before Blender 4.0
  kSheen,          // and its sheen
  kGgx,            // microfacets, coloured by Fresnel's equations
  kCorrelatedGgx,  // with masking and shadowing that know of each other
  kBeckmann,       // another distribution
  kClearcoat,      // of Burley's GTR1: the Principled BSDF before Blender 4.0
};

/// One lobe of a BRDF beside the paper's, evaluated light point by light point.
struct Lobe {
  LobeKind kind = LobeKind::kLambert;
  Vec3f colour;         // albedo; microfacets: reflectance at normal incidence
  Vec3f edge;           // microfacets: reflectance at grazing incidence; Oren-Nayar: of light that bounces
                        // between facets
  float roughness = 0;  // microfacets: alpha; else Blender's own
  float ior = 0;  // microfacets: of the dielectric whose Fresnel term leads from colour to edge; 0: colour; <
                  // 0: Schlick
};

/// Lobes that are not microfacets: they change slowly over a luminaire, so that Lambert's visible part of it
/// serves for them.
constexpr bool is_diffuse(LobeKind kind) {
  return kind < LobeKind::kGgx;
}

/// The paper's BRDF (mirror + Phong + ideal diffuse, by their albedos), further lobes, and what is not
/// reflected.
struct Closures {
  Vec3d diffuse, phong, mirror;
  double phong_exponent = 0;
  Vec3d emission;       // radiance towards the viewer
  Vec3d transparency;   // share of the light that goes straight through
  double holdout = 0;   // share of the pixel that becomes a hole in the film
  Vec3f smooth_normal;  // where `bumped`: the normal before the bump
  bool bumped = false;
  bool facet_bumps = false;  // which shadowing of bumps (lobes.h): Conty's if true, Chiang's if not

  static constexpr uint32_t kMaxLobes = 8;
  bool has_diffuse_lobes = false, has_glossy_lobes = false;
  uint8_t lobe_count = 0;
  std::array<Lobe, kMaxLobes> lobes;

  /// Further lobes than kMaxLobes are left out; the export notes it.
  void add(const Lobe& lobe) {
    if (lobe_count == kMaxLobes) return;
    lobes[lobe_count++] = lobe;
    (is_diffuse(lobe.kind) ? has_diffuse_lobes : has_glossy_lobes) = true;
  }
  bool has_glossy() const { return has_glossy_lobes || max_component(phong) > 0; }
  /// Reflects light from luminaires in some way.
  bool reflects() const { return lobe_count > 0 || max_component(diffuse + phong) > 0; }
};

}  // namespace penumbra
