// SPDX-License-Identifier: GPL-3.0-or-later
// BOUNDED with antialiasing: the promise is about the filtered pixel, and primary rays are part of what it
// costs.
#pragma once

#include "render/block.h"

namespace penumbra {

/// Like render_block, but with as many primary rays in each pixel as its tolerance needs. First of all one
/// through the centre, with four to each luminaire, and four that only ask which surface they meet; or, where
/// the centre does not show one plain surface, four whole samples. Where they, or the neighbours', tell of an
/// edge or of penumbra, more. Shadows on smooth surfaces: centre_light.h; edges: edge_light.h.
void render_filtered_block(const RenderContext& context, const Rectangle& core, RenderTally& tally);

}  // namespace penumbra
