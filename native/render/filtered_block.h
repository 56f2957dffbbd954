// SPDX-License-Identifier: GPL-3.0-or-later
// BOUNDED with antialiasing: the promise is about the filtered pixel, and primary rays are part of what it
// costs.
#pragma once

#include "render/block.h"

namespace penumbra {

/// Like render_block, but with as many primary rays in each pixel as its tolerance needs: four at first;
/// where they, or their neighbours', tell of an edge or of penumbra, more, with rays to each luminaire that
/// may be in penumbra there. Shadows on smooth surfaces: centre_light.h; edges: edge_light.h.
void render_filtered_block(const RenderContext& context, const Rectangle& core, RenderTally& tally);

}  // namespace penumbra
