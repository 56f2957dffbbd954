// SPDX-License-Identifier: GPL-3.0-or-later
#include "material/colour_spaces.h"

#include <cmath>

namespace penumbra {
namespace {

/// Hue, 0 ... 1, of a colour whose largest and smallest component differ.
float hue(const Vec3f& c, float high, float low) {
  const float range = high - low;
  const float sextant = c.x == high   ? (c.y - c.z) / range
                        : c.y == high ? 2 + (c.z - c.x) / range
                                      : 4 + (c.x - c.y) / range;
  return sextant < 0 ? sextant / 6 + 1 : sextant / 6;
}

/// The fully saturated colour of a hue.
Vec3f pure(float h) {
  const auto clamp = [](float x) { return std::clamp(x, 0.0f, 1.0f); };
  return {clamp(std::abs(h * 6 - 3) - 1), clamp(2 - std::abs(h * 6 - 2)), clamp(2 - std::abs(h * 6 - 4))};
}

}  // namespace

Vec3f hsv_from_rgb(const Vec3f& c) {
  const float high = max_component(c), low = std::min({c.x, c.y, c.z});
  if (high == 0 || high == low) return {0, 0, high};
  return {hue(c, high, low), (high - low) / high, high};
}

Vec3f rgb_from_hsv(const Vec3f& c) {
  if (c.y == 0) return {c.z, c.z, c.z};
  const float h = c.x == 1 ? 0 : c.x * 6, i = std::floor(h), f = h - i;
  const float p = c.z * (1 - c.y), q = c.z * (1 - c.y * f), t = c.z * (1 - c.y * (1 - f)), v = c.z;
  if (i == 0) return {v, t, p};
  if (i == 1) return {q, v, p};
  if (i == 2) return {p, v, t};
  if (i == 3) return {p, q, v};
  if (i == 4) return {t, p, v};
  return {v, p, q};
}

Vec3f hsl_from_rgb(const Vec3f& c) {
  const float high = max_component(c), low = std::min({c.x, c.y, c.z});
  const float l = std::min(1.0f, (high + low) / 2);
  if (high == low) return {0, 0, l};
  return {hue(c, high, low), (high - low) / (l > 0.5f ? 2 - high - low : high + low), l};
}

Vec3f rgb_from_hsl(const Vec3f& c) {
  const float chroma = (1 - std::abs(2 * c.z - 1)) * c.y;
  return (pure(c.x) - Vec3f{0.5f, 0.5f, 0.5f}) * chroma + Vec3f{c.z, c.z, c.z};
}

float linear_from_srgb(float c) {
  if (c < 0.04045f) return c < 0 ? 0 : c / 12.92f;
  return std::pow((c + 0.055f) / 1.055f, 2.4f);
}

}  // namespace penumbra
