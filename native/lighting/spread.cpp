// SPDX-License-Identifier: GPL-3.0-or-later
#include "lighting/spread.h"

#include <algorithm>

namespace penumbra {

void spread(std::vector<uint8_t>& flags, uint32_t width, uint32_t height, int reach) {
  std::vector<uint8_t> rows(flags.size(), 0);
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x)
      for (int d = -reach; d <= reach; ++d)
        if (int(x) + d >= 0 && x + d < width) rows[y * width + x] |= flags[y * width + x + d];
  std::fill(flags.begin(), flags.end(), uint8_t(0));
  for (uint32_t y = 0; y < height; ++y)
    for (int d = -reach; d <= reach; ++d)
      if (int(y) + d >= 0 && y + d < height)
        for (uint32_t x = 0; x < width; ++x) flags[y * width + x] |= rows[(y + d) * width + x];
}

}  // namespace penumbra
