// SPDX-License-Identifier: GPL-3.0-or-later
// What a surface reflects in all, for the colour passes.
#pragma once

#include "scene/closures.h"

namespace penumbra {

/// Of all diffuse lobes, r, g, b.
Vec3d diffuse_albedo(const Closures& closures);

/// Of all glossy lobes and the mirror, r, g, b. Microfacets count as the mirror that they are made of, seen
/// at an angle of this cosine to the normal.
Vec3d glossy_albedo(const Closures& closures, double cosine);

}  // namespace penumbra
