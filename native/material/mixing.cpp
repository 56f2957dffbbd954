// SPDX-License-Identifier: GPL-3.0-or-later
// The blend modes of the Mix node. Inputs: factor, two colours. Names after the dot are Blender's own.
#include <cmath>

#include "material/colour_spaces.h"
#include "material/machine.h"

namespace penumbra {
namespace {

/// A mode that treats each component by itself, as a function of factor and two numbers.
template <auto F>
void by_component(Machine& m, const Operation& o) {
  const float t = m.number(o, 0);
  const Vec3f &a = m.in(o, 1), &b = m.in(o, 2);
  m.set(o, Vec3f{F(t, a.x, b.x), F(t, a.y, b.y), F(t, a.z, b.z)});
}

/// A mode whose full effect is F(a, b): lerp(a, F(a, b), factor).
template <auto F>
void simple(Machine& m, const Operation& o) {
  by_component<[](float t, float a, float b) { return (1 - t) * a + t * F(a, b); }>(m, o);
}

float overlay(float t, float a, float b) {
  return a < 0.5f ? a * (1 - t + 2 * t * b) : 1 - (1 - t + 2 * t * (1 - b)) * (1 - a);
}

float dodge(float t, float a, float b) {
  if (a == 0) return 0;
  const float divisor = 1 - t * b;
  return divisor <= 0 ? 1 : std::min(a / divisor, 1.0f);
}

float burn(float t, float a, float b) {
  const float divisor = 1 - t + t * b;
  return divisor <= 0 ? 0 : std::clamp(1 - (1 - a) / divisor, 0.0f, 1.0f);
}

float soft_light(float t, float a, float b) {
  const float screen = 1 - (1 - b) * (1 - a);
  return (1 - t) * a + t * ((1 - a) * b * a + a * screen);
}

Vec3f lerp(const Vec3f& a, const Vec3f& b, float t) {
  return a * (1 - t) + b * t;
}

/// A mode of hue, saturation and value: a's colour with some components of b's.
template <auto F>
void by_hsv(Machine& m, const Operation& o) {
  m.set(o, F(m.number(o, 0), m.in(o, 1), m.in(o, 2)));
}

Vec3f mix_hue(float t, const Vec3f& a, const Vec3f& b) {
  const Vec3f from = hsv_from_rgb(b), to = hsv_from_rgb(a);
  return from.y == 0 ? a : lerp(a, rgb_from_hsv({from.x, to.y, to.z}), t);
}
Vec3f mix_colour(float t, const Vec3f& a, const Vec3f& b) {
  const Vec3f from = hsv_from_rgb(b), to = hsv_from_rgb(a);
  return from.y == 0 ? a : lerp(a, rgb_from_hsv({from.x, from.y, to.z}), t);
}
Vec3f mix_saturation(float t, const Vec3f& a, const Vec3f& b) {
  const Vec3f from = hsv_from_rgb(b), to = hsv_from_rgb(a);
  return to.y == 0 ? a : rgb_from_hsv({to.x, (1 - t) * to.y + t * from.y, to.z});
}
Vec3f mix_value(float t, const Vec3f& a, const Vec3f& b) {
  const Vec3f from = hsv_from_rgb(b), to = hsv_from_rgb(a);
  return rgb_from_hsv({to.x, to.y, (1 - t) * to.z + t * from.z});
}

/// As MIX, with a factor for each component.
void non_uniform(Machine& m, const Operation& o) {
  const Vec3f &t = m.in(o, 0), &a = m.in(o, 1), &b = m.in(o, 2);
  m.set(o, a + t * (b - a));
}

void saturate(Machine& m, const Operation& o) {
  const auto one = [](float x) { return std::clamp(x, 0.0f, 1.0f); };
  const Vec3f& c = m.in(o, 0);
  m.set(o, Vec3f{one(c.x), one(c.y), one(c.z)});
}

constexpr NamedOperation kOperations[] = {
    {"mix.MIX", simple<[](float, float b) { return b; }>},
    {"mix.ADD", simple<[](float a, float b) { return a + b; }>},
    {"mix.SUBTRACT", simple<[](float a, float b) { return a - b; }>},
    {"mix.MULTIPLY", simple<[](float a, float b) { return a * b; }>},
    {"mix.DIVIDE", simple<[](float a, float b) { return b != 0 ? a / b : a; }>},
    {"mix.DIFFERENCE", simple<[](float a, float b) { return std::abs(a - b); }>},
    {"mix.EXCLUSION", by_component<[](float t, float a, float b) {
       return std::max((1 - t) * a + t * (a + b - 2 * a * b), 0.0f);
     }>},
    {"mix.DARKEN", simple<[](float a, float b) { return std::min(a, b); }>},
    {"mix.LIGHTEN", simple<[](float a, float b) { return std::max(a, b); }>},
    {"mix.SCREEN",
     by_component<[](float t, float a, float b) { return 1 - (1 - t + t * (1 - b)) * (1 - a); }>},
    {"mix.OVERLAY", by_component<overlay>},
    {"mix.DODGE", by_component<dodge>},
    {"mix.BURN", by_component<burn>},
    {"mix.SOFT_LIGHT", by_component<soft_light>},
    {"mix.LINEAR_LIGHT", by_component<[](float t, float a, float b) { return a + t * (2 * b - 1); }>},
    {"mix.HUE", by_hsv<mix_hue>},
    {"mix.SATURATION", by_hsv<mix_saturation>},
    {"mix.COLOR", by_hsv<mix_colour>},
    {"mix.VALUE", by_hsv<mix_value>},
    {"mix.non_uniform", non_uniform},
    {"saturate", saturate},
};

}  // namespace

std::span<const NamedOperation> mix_operations() {
  return kOperations;
}

}  // namespace penumbra
