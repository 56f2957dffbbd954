// SPDX-License-Identifier: GPL-3.0-or-later
#include "luminaire/emitter.h"

namespace penumbra {

void Emitter::form_factors(const SurfaceColumns& surfaces, double* out) const {
  for (uint32_t i = 0; i < surfaces.count; ++i) out[i] = form_factor(surfaces.point(i));
}

void Emitter::evaluate_each(const SurfaceColumns& surfaces, const float* u, const float* v, uint32_t points,
                            LightPoints& out) const {
  alignas(64) float own_u[kBatch], own_v[kBatch];
  LightPoints own;
  for (uint32_t i = 0; i < surfaces.count; ++i) {
    for (uint32_t k = 0; k < points; ++k) {
      own_u[k] = u[k * surfaces.count + i];
      own_v[k] = v[k * surfaces.count + i];
    }
    evaluate(surfaces.point(i), own_u, own_v, points, own);
    for (uint32_t k = 0; k < points; ++k) {
      const uint32_t at = k * surfaces.count + i;
      out.x[at] = own.x[k];
      out.y[at] = own.y[k];
      out.z[at] = own.z[k];
      out.form_factor[at] = own.form_factor[k];
    }
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
