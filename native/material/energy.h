// SPDX-License-Identifier: GPL-3.0-or-later
// How much light rough microfacets reflect in all: tables, made when they are first asked for.
#pragma once

namespace penumbra {

/// Directional albedo of GGX microfacets that reflect everything; below 1 by the light that is scattered more
/// than once. cosine: between viewer and normal. roughness: Blender's own.
float ggx_albedo(float cosine, float roughness);

/// The cosine-weighted mean of that.
float mean_ggx_albedo(float roughness);

/// Directional albedo of a dielectric with this index of refraction.
float dielectric_albedo(float cosine, float roughness, float ior);

}  // namespace penumbra
