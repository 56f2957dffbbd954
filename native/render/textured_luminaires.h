// SPDX-License-Identifier: GPL-3.0-or-later
// Surfaces whose emission varies, as luminaires.
#pragma once

#include "luminaire/luminaire.h"
#include "material/evaluate.h"
#include "visibility/geometry.h"

namespace penumbra {

/// Splits the triangles of each textured luminaire of the scene where their emission varies, and takes its
/// mean on each part, and over the directions that it is seen from. At most 256 parts are added to its
/// triangles. A luminaire of many hues becomes three, one a channel; one that shines differently to its two
/// sides becomes one a side.
std::vector<Luminaire> textured_luminaires(const Scene& scene, const Geometry& geometry,
                                           const Materials& materials);

}  // namespace penumbra
