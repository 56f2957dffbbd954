// SPDX-License-Identifier: GPL-3.0-or-later
// The background as luminaires.
#pragma once

#include <vector>

#include "luminaire/luminaire.h"
#include "scene/scene.h"

namespace penumbra {

/// None where it gives no light, one where all of it has one hue, else one for each channel, so that form
/// factors and points can be exact for each.
std::vector<Luminaire> sky_luminaires(const Background& background);

}  // namespace penumbra
