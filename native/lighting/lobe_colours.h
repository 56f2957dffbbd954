// SPDX-License-Identifier: GPL-3.0-or-later
// What a luminaire's unshadowed light becomes at a surface: colours for the two weights that lighting
// samples.
#pragma once

#include "luminaire/luminaire.h"
#include "material/shading_point.h"

namespace penumbra {

/// The diffuse lobes under one luminaire, by light points on a grid: as a share of Lambert's, other lobes
/// change slowly over a luminaire.
struct DiffuseColour {
  Vec3d mean;  // unshadowed radiance is this x radiance x form factor; the albedo of Lambert's lobe alone
  double weight = 1;  // mean of weigh_diffuse() is this x form factor

  /// Radiance is this x radiance x mean of weigh_diffuse(), where only that is sampled.
  Vec3d of_weight() const { return weight > 0 ? mean / weight : Vec3d{}; }
};
DiffuseColour diffuse_colour(const ShadingPoint& point, const Luminaire& luminaire);

/// Colour of the glossy lobes, where only their weight is sampled: radiance is this x luminaire's radiance x
/// mean of evaluate_glossy(). Their mean colour over the grid, the albedo of a Phong lobe alone.
Vec3d glossy_colour(const ShadingPoint& point, const Luminaire& luminaire);

}  // namespace penumbra
