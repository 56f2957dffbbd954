// SPDX-License-Identifier: GPL-3.0-or-later
// What pixels have seen, told to their neighbours.
#pragma once

#include <cstdint>
#include <vector>

namespace penumbra {

/// Ors each pixel's flags over the square of (2 reach + 1)^2 pixels around it.
void spread(std::vector<uint8_t>& flags, uint32_t width, uint32_t height, int reach);

}  // namespace penumbra
