// SPDX-License-Identifier: GPL-3.0-or-later
// From the unit square to the unit disk.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

namespace penumbra {

/// Points of [0, 1)^2 to the unit disk, uniformly in area and with little distortion (Shirley and Chiu 1997).
inline void square_to_disk(const float* u, const float* v, uint32_t count, float* x, float* y) {
  for (uint32_t i = 0; i < count; ++i) {
    const float a = 2 * u[i] - 1, b = 2 * v[i] - 1;
    const bool wide = std::abs(a) > std::abs(b);
    const float radius = wide ? a : b;
    const float ratio = radius == 0 ? 0 : (wide ? b : a) / radius;
    const float angle = float(std::numbers::pi / 4) * ratio;
    const float c = std::cos(angle) * radius, d = std::sin(angle) * radius;
    x[i] = wide ? c : d;
    y[i] = wide ? d : c;
  }
}

}  // namespace penumbra
