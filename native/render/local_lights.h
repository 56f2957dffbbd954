// SPDX-License-Identifier: GPL-3.0-or-later
// The luminaires of one block of the frame, where the scene has many.
#pragma once

#include "luminaire/light_tree.h"
#include "render/block.h"

namespace penumbra {

/// Side in pixels of the squares of the frame that share their luminaires: a multiple of kTile.
inline constexpr uint32_t kLocalSide = 64;

class LocalLights {
 public:
  /// What a grid of pixels sees decides; it covers the block's bucket of the frame, whatever part of it is
  /// rendered, so that a pixel does not depend on where a border cuts.
  LocalLights(const RenderContext& context, const LightTree& tree, const Rectangle& block);

  /// The render's with these luminaires.
  const RenderContext& context() const { return context_; }

 private:
  std::vector<Luminaire> luminaires_;
  RenderContext context_;
};

}  // namespace penumbra
