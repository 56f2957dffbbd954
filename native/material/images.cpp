// SPDX-License-Identifier: GPL-3.0-or-later
// The operation that looks up an image.
#include "material/machine.h"
#include "material/textures.h"

namespace penumbra {
namespace {

/// Input: coordinates, of which x and y count. data: the image. Alpha goes to the second register.
void image(Machine& m, const Operation& o) {
  const Vec3f& p = m.in(o, 0);
  const Texel texel = m.textures->lookup(uint32_t(o.data), p.x, p.y);
  m.set(o, texel.colour);
  m.set_second(o, texel.alpha);
}

constexpr NamedOperation kOperations[] = {{"image", image, false, DataKind::kImage}};

}  // namespace

std::span<const NamedOperation> image_operations() {
  return kOperations;
}

}  // namespace penumbra
