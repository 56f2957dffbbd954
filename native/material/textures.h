// SPDX-License-Identifier: GPL-3.0-or-later
// Image lookups through OpenImageIO's texture system, which keeps no more pixels than its cache may hold.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "math/vector.h"
#include "scene/image.h"

namespace penumbra {

struct Texel {
  Vec3f colour;
  float alpha = 1;

  /// What stands for an image that cannot be read, as in Cycles: magenta.
  static Texel missing() { return {{1, 0, 1}, 1}; }
};

/// Threads may look up at the same time.
class Textures {
 public:
  /// Opens each file's header. What cannot be read is magenta, and a sentence in problems() says so.
  explicit Textures(const std::vector<Image>& images);
  ~Textures();

  Texel lookup(uint32_t image, float u, float v) const;
  /// One sentence for each image that could not be read, now or while rendering.
  std::vector<std::string> problems() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Floats, rows from the bottom, as the bytes of an image file. Throws std::runtime_error if it cannot be
/// done.
std::string encode_image(uint32_t width, uint32_t height, uint32_t channels, const float* pixels);

}  // namespace penumbra
