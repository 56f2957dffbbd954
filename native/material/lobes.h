// SPDX-License-Identifier: GPL-3.0-or-later
// The lobes beside the paper's: what Cycles' closures reflect, so that both engines agree.
#pragma once

#include "material/shading_point.h"

namespace penumbra {

/// alpha of microfacets at and below which they are a mirror (Cycles' BSDF_ROUGHNESS_SQ_THRESH = 1e-7).
inline constexpr float kMirrorAlphaSquared = 1e-7f;

/// pi x BRDF without its colour, and how far the colour has gone from Lobe::colour to Lobe::edge.
struct LobeValue {
  float value, edge;
};
LobeValue evaluate_lobe(const Lobe& lobe, const ShadingPoint& point, const Vec3f& to_light);

/// pi x BRDF.
inline Vec3f coloured(const Lobe& lobe, const LobeValue& v) {
  return (lobe.colour * (1 - v.edge) + lobe.edge * v.edge) * v.value;
}

/// Lobe::edge of a rough diffuse lobe that loses no light between its facets, of this albedo (0 ... 1).
Vec3f oren_nayar_edge(const Vec3f& colour, const Vec3f& albedo, float roughness);

/// Unpolarised reflectance of a dielectric for light at the angle of this cosine.
float fresnel_dielectric(float cosine, float ior);

/// How far Fresnel's term has gone from normal (0) to grazing incidence (1). ior < 0: Schlick's
/// approximation.
float fresnel_edge(float cosine, float ior);

/// Share of a bumped surface's light that its smooth normal lets pass: Chiang, Li and Burley 2019, "Taming
/// the shadow terminator".
float bump_shadowing(const Vec3f& smooth, const Vec3f& bumped, const Vec3f& to_light);
/// Likewise, for bumps as facets: Conty, Lecocq and Stein 2019, "A microfacet-based shadowing function to
/// solve the bump terminator problem".
float facet_bump_shadowing(const Vec3f& smooth, const Vec3f& bumped, const Vec3f& to_light);

}  // namespace penumbra
