// SPDX-License-Identifier: GPL-3.0-or-later
// One pixel, told step by step.
#pragma once

#include <string>

#include "render/block.h"

namespace penumbra {

/// Renders `block` (full frame), which holds the pixel, into the film, and tells of the pixel in lines of
/// text: what its centre ray meets, and for each luminaire its unshadowed form factor, which of 16 points on
/// it are seen, and what lighting decided. `film_block`: renders a block.
std::string debug_pixel(const RenderContext& context, const Rectangle& block, uint32_t x, uint32_t y,
                        void (*film_block)(const RenderContext&, const Rectangle&, RenderTally&));

}  // namespace penumbra
