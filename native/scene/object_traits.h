// SPDX-License-Identifier: GPL-3.0-or-later
// What an object is to passes and to the film, beside its shape and its materials.
#pragma once

#include <cstdint>

namespace penumbra {

inline constexpr uint32_t kNoLightGroup = ~0u;

struct ObjectTraits {
  float pass_index = 0;
  float object_matte = 0, asset_matte = 0;  // Cryptomatte's ids: hashes of names
  uint32_t light_group = kNoLightGroup;     // of the light that it emits
  bool holdout = false;                     // the camera sees a hole in its place
  bool indirect_only = false;               // the camera does not see it
};

}  // namespace penumbra
