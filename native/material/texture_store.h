// SPDX-License-Identifier: GPL-3.0-or-later
// Textures that stay when their scene goes.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "material/textures.h"

namespace penumbra {

/// Remembers the textures of the last scene, with the pixels that were read for it. For one thread.
class TextureStore {
 public:
  /// Those of the last call if the images are the same: files by path and time of their last change, bytes by
  /// their content.
  std::shared_ptr<const Textures> textures_of(const std::vector<Image>& images);

 private:
  uint64_t fingerprint_ = 0;
  std::shared_ptr<const Textures> last_;
};

}  // namespace penumbra
