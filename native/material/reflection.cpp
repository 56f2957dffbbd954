// SPDX-License-Identifier: GPL-3.0-or-later
// Reflected light, light point by light point.
#include <cmath>

#include "luminaire/luminaire.h"
#include "material/lobes.h"

namespace penumbra {
namespace {

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

/// pi x BRDF of all diffuse lobes.
Vec3f diffuse(const ShadingPoint& point, const Vec3f& to_light) {
  const Closures& m = point.material;
  Vec3f sum(m.diffuse);
  for (uint32_t i = 0; i < m.lobe_count; ++i)
    if (is_diffuse(m.lobes[i].kind)) sum += coloured(m.lobes[i], evaluate_lobe(m.lobes[i], point, to_light));
  return sum;
}

/// pi x BRDF of all glossy lobes.
Vec3f glossy(const ShadingPoint& point, const Vec3f& to_light) {
  const Closures& m = point.material;
  Vec3f sum;
  for (uint32_t i = 0; i < m.lobe_count; ++i)
    if (!is_diffuse(m.lobes[i].kind)) sum += coloured(m.lobes[i], evaluate_lobe(m.lobes[i], point, to_light));
  const float cosine = dot(to_light, Vec3f(point.mirror_direction)), n = float(m.phong_exponent);
  if (max_component(m.phong) > 0 && cosine > 0) sum += Vec3f(m.phong) * ((n + 2) / 2 * std::pow(cosine, n));
  return sum;
}

}  // namespace

void evaluate_glossy(const ShadingPoint& point, const float* x, const float* y, const float* z,
                     const float* form_factor, uint32_t count, float* out, Vec3f* colours) {
  if (!point.material.has_glossy_lobes) return evaluate_phong(point, x, y, z, form_factor, count, out);
  for (uint32_t i = 0; i < count; ++i) {
    const Vec3f colour = form_factor[i] > 0 ? glossy(point, normalize(Vec3f(x[i], y[i], z[i]))) : Vec3f{};
    out[i] = form_factor[i] > 0 ? form_factor[i] * max_component(colour) : 0.0f;
    if (colours) colours[i] = colour * form_factor[i];
  }
}

void weigh_diffuse(const ShadingPoint& point, const float* x, const float* y, const float* z, uint32_t count,
                   float* form_factor) {
  if (!point.material.has_diffuse_lobes) return;
  for (uint32_t i = 0; i < count; ++i)
    if (form_factor[i] > 0)
      form_factor[i] *= max_component(diffuse(point, normalize(Vec3f(x[i], y[i], z[i]))));
}

void add_reflection(const ShadingPoint& point, const float* x, const float* y, const float* z,
                    const float* form_factor, uint32_t count, Reflection& sum) {
  const Closures& m = point.material;
  for (uint32_t i = 0; i < count; ++i) {
    if (!(form_factor[i] > 0)) continue;
    const Vec3f to_light = normalize(Vec3f(x[i], y[i], z[i]));
    sum.form_factor += double(form_factor[i]);
    if (m.has_diffuse_lobes) {
      const Vec3f one = diffuse(point, to_light) * form_factor[i];
      sum.diffuse += Vec3d(one);
      sum.diffuse_weight += double(max_component(one));
    }
    if (!m.has_glossy_lobes) continue;
    const Vec3f one = glossy(point, to_light) * form_factor[i];
    sum.glossy += Vec3d(one);
    sum.weight += double(max_component(one));
  }
  if (m.has_glossy_lobes || !m.has_glossy()) return;
  float phong[kBatch];
  evaluate_phong(point, x, y, z, form_factor, count, phong);
  for (uint32_t i = 0; i < count; ++i) sum.weight += double(phong[i]);
}

}  // namespace penumbra
