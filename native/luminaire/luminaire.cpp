// SPDX-License-Identifier: GPL-3.0-or-later
#include "luminaire/luminaire.h"

#include <algorithm>
#include <numbers>

#include "luminaire/flat_emitter.h"
#include "luminaire/mesh_emitter.h"
#include "luminaire/point_emitter.h"
#include "luminaire/spread_emitter.h"
#include "luminaire/sun_emitter.h"

namespace penumbra {
namespace {

struct Parts {
  std::shared_ptr<const Emitter> emitter;
  Vec3d radiance;
};

Parts make_parts(const AreaLuminaire& d, const Normalization& n) {
  constexpr double kWidest = std::numbers::pi - 1e-3;  // where nothing is left of the fall
  if (d.spread < kWidest) return {std::make_shared<SpreadEmitter>(d, n), d.radiance};
  return {std::make_shared<FlatEmitter>(d, n), d.radiance};
}

Parts make_parts(const PointLuminaire& d, const Normalization& n) {
  return {std::make_shared<PointEmitter>(d, n), d.intensity * (n.scale * n.scale)};  // of render space
}

Parts make_parts(const SunLuminaire& d, const Normalization&) {
  return {std::make_shared<SunEmitter>(d), d.irradiance / std::numbers::pi};
}

Parts make_parts(const MeshLuminaire& d, const Normalization& n) {
  return {std::make_shared<MeshEmitter>(d, n), d.radiance};
}

}  // namespace

Luminaire Luminaire::of_channel(uint8_t channel) const {
  Luminaire result = *this;
  result.channel_ = channel;
  result.radiance_ = radiance_ * Vec3d{double(channel == 0), double(channel == 1), double(channel == 2)};
  return result;
}

Luminaire::Luminaire(const LuminaireDescription& description, const Normalization& normalization,
                     uint32_t light_group)
    : light_group_(light_group) {
  const auto parts = std::visit([&](const auto& d) { return make_parts(d, normalization); }, description);
  name_ = std::visit([](const auto& d) { return d.name; }, description);
  emitter_ = parts.emitter;
  radiance_ = parts.radiance;
  cast_shadow_ = std::visit([](const auto& d) { return d.cast_shadow; }, description);
  role_ = std::visit([](const auto& d) { return d.role; }, description);
}

void Luminaire::form_factors(const SurfaceColumns& surfaces, double* out) const {
  emitter_->form_factors(surfaces, out);
  if (role_.receivers.empty()) return;
  for (uint32_t i = 0; i < surfaces.count; ++i)
    if (!lights(surfaces.receiver_set[i])) out[i] = 0;
}

void Luminaire::evaluate(const SurfacePoint& surface, const float* u, const float* v, uint32_t count,
                         LightPoints& out) const {
  emitter_->evaluate(surface, u, v, count, out);
  if (!lights(surface.receiver_set)) std::fill(out.form_factor, out.form_factor + count, 0.0f);
}

}  // namespace penumbra
