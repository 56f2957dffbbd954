// SPDX-License-Identifier: GPL-3.0-or-later
// Which luminaires a part of the picture takes one by one, and which as groups.
#pragma once

#include <span>
#include <vector>

#include "lighting/lighting.h"
#include "luminaire/light_tree.h"

namespace penumbra {

/// Scenes of at most so many luminaires need no tree.
inline constexpr size_t kFewLuminaires = 24;

/// A cut through the tree, the dimmest first: nodes are split, the largest first, until each matters little
/// to all of some surface points (`tolerance`, display = radiance x display_scale) or there are many of them.
/// What cannot be grouped comes last. Any cut is right, this one is quick.
std::vector<Luminaire> cut_luminaires(const LightTree& tree, std::span<const LitPoint> probes,
                                      double tolerance, double display_scale);

}  // namespace penumbra
