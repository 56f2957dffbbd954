// SPDX-License-Identifier: GPL-3.0-or-later
#include "luminaire/emitter.h"

namespace penumbra {

void Emitter::form_factors(const SurfaceColumns& surfaces, double* out) const {
  for (uint32_t i = 0; i < surfaces.count; ++i) out[i] = form_factor(surfaces.point(i));
}

void Emitter::evaluate_each(const SurfaceColumns& surfaces, const float* u, const float* v,
                            LightPoints& out) const {
  LightPoints one;
  for (uint32_t i = 0; i < surfaces.count; ++i) {
    evaluate(surfaces.point(i), u + i, v + i, 1, one);
    out.x[i] = one.x[0];
    out.y[i] = one.y[0];
    out.z[i] = one.z[0];
    out.form_factor[i] = one.form_factor[0];
  }
}

double midpoint_form_factor(const Emitter& emitter, const SurfacePoint& surface, uint32_t side) {
  alignas(64) float u[kBatch], v[kBatch];
  LightPoints points;
  double sum = 0;
  for (uint32_t first = 0; first < side * side; first += kBatch) {
    for (uint32_t i = 0; i < kBatch; ++i) {
      u[i] = (float((first + i) % side) + 0.5f) / float(side);
      v[i] = (float((first + i) / side) + 0.5f) / float(side);
    }
    emitter.evaluate(surface, u, v, kBatch, points);
    for (float f : points.form_factor) sum += double(f);
  }
  return sum / (double(side) * side);
}

}  // namespace penumbra
