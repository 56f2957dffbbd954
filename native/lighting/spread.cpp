// SPDX-License-Identifier: GPL-3.0-or-later
#include "lighting/spread.h"

#include <algorithm>

namespace penumbra {

void spread(std::vector<uint8_t>& flags, uint32_t width, uint32_t height, int reach) {
  std::vector<uint8_t> rows(flags.size(), 0);
  const int w = int(width), h = int(height);
  // Each shift by whole rows of flags, which the compiler vectorises.
  const auto add = [w](const uint8_t* from, uint8_t* to, int shift) {
    for (int x = std::max(0, -shift); x < std::min(w, w - shift); ++x) to[x] |= from[x + shift];
  };
  for (int y = 0; y < h; ++y)
    for (int d = -reach; d <= reach; ++d) add(flags.data() + y * w, rows.data() + y * w, d);
  std::fill(flags.begin(), flags.end(), uint8_t(0));
  for (int y = 0; y < h; ++y)
    for (int d = std::max(-reach, -y); d <= std::min(reach, h - 1 - y); ++d)
      add(rows.data() + (y + d) * w, flags.data() + y * w, 0);
}

}  // namespace penumbra
