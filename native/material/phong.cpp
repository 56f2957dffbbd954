// SPDX-License-Identifier: GPL-3.0-or-later
#include "material/phong.h"

#include <cmath>

namespace penumbra {

void evaluate_phong(const ShadingPoint& point, const float* x, const float* y, const float* z,
                    const float* form_factor, uint32_t count, float* out) {
  const Vec3f mirror(point.mirror_direction);
  const float exponent = float(point.material.phong_exponent), factor = (exponent + 2) / 2;
  for (uint32_t i = 0; i < count; ++i) {
    const Vec3f d(x[i], y[i], z[i]);
    const float cosine = dot(d, mirror) / length(d);
    out[i] = form_factor[i] > 0 && cosine > 0 ? form_factor[i] * factor * std::pow(cosine, exponent) : 0.0f;
  }
}

}  // namespace penumbra
