// SPDX-License-Identifier: GPL-3.0-or-later
// Operations on colours: Hue/Saturation, Gamma, Invert, Bright/Contrast, ramps, curves, separate and combine.
#include <cmath>

#include "material/colour_spaces.h"
#include "material/machine.h"

namespace penumbra {
namespace {

Vec3f lerp(const Vec3f& a, const Vec3f& b, float t) {
  return a * (1 - t) + b * t;
}

Vec3f at_least_zero(const Vec3f& c) {
  return {std::max(c.x, 0.0f), std::max(c.y, 0.0f), std::max(c.z, 0.0f)};
}

/// Inputs: factor, colour, hue, saturation, value.
void hue_saturation(Machine& m, const Operation& o) {
  Vec3f c = hsv_from_rgb(m.in(o, 1));
  c.x = std::fmod(c.x + m.number(o, 2) + 0.5f, 1.0f);
  c.y = std::clamp(c.y * m.number(o, 3), 0.0f, 1.0f);
  c.z *= m.number(o, 4);
  m.set(o, at_least_zero(lerp(m.in(o, 1), rgb_from_hsv(c), m.number(o, 0))));
}

void gamma(Machine& m, const Operation& o) {
  const float g = m.number(o, 1);
  const auto one = [g](float c) { return g == 0 ? 1 : c > 0 ? std::pow(c, g) : c; };
  const Vec3f& c = m.in(o, 0);
  m.set(o, Vec3f{one(c.x), one(c.y), one(c.z)});
}

void invert(Machine& m, const Operation& o) {
  m.set(o, lerp(m.in(o, 1), Vec3f{1, 1, 1} - m.in(o, 1), m.number(o, 0)));
}

void bright_contrast(Machine& m, const Operation& o) {
  const float a = 1 + m.number(o, 2), b = m.number(o, 1) - m.number(o, 2) / 2;
  m.set(o, at_least_zero(m.in(o, 0) * a + Vec3f{b, b, b}));
}

template <auto F>
void convert(Machine& m, const Operation& o) {
  m.set(o, F(m.in(o, 0)));
}

/// A table: its size, whether it is stepped, then r, g, b, a for each place from 0 to 1.
void ramp(Machine& m, const Operation& o) {
  const float* table = m.tables + o.data;
  const int size = int(table[0]);
  const bool stepped = table[1] != 0;
  const float* values = table + 2;
  const float x = std::clamp(m.number(o, 0), 0.0f, 1.0f) * float(size - 1);
  const int i = x >= 0 ? std::min(int(x), size - 1) : 0;
  const float t = stepped || i + 1 >= size ? 0 : x - float(i);
  const auto at = [&](int channel) {
    const float a = values[4 * i + channel];
    return t > 0 ? a * (1 - t) + values[4 * (i + 1) + channel] * t : a;
  };
  m.set(o, Vec3f{at(0), at(1), at(2)});
  m.set_second(o, at(3));
}

/// Inputs: factor, colour. A table: its size, the first and last place, whether it goes on beyond them, then
/// r, g, b for each place.
void curves(Machine& m, const Operation& o) {
  const float* table = m.tables + o.data;
  const int size = int(table[0]);
  const float first = table[1], range = table[2] - table[1];
  const bool extrapolate = table[3] != 0;
  const auto one = [&](int channel) {
    const auto value = [&](int i) { return table[4 + 3 * i + channel]; };
    const float x = (m.in(o, 1)[channel] - first) / range * float(size - 1);
    if (extrapolate && x < 0) return value(0) + (value(1) - value(0)) * x;
    if (extrapolate && x > float(size - 1))
      return value(size - 1) + (value(size - 1) - value(size - 2)) * (x - float(size - 1));
    const float inside = std::clamp(x, 0.0f, float(size - 1));
    const int i = inside >= 0 ? std::min(int(inside), size - 2) : 0;
    const float t = inside - float(i);
    return value(i) * (1 - t) + value(i + 1) * t;
  };
  m.set(o, lerp(m.in(o, 1), {one(0), one(1), one(2)}, m.number(o, 0)));
}

constexpr NamedOperation kOperations[] = {
    {"hue_saturation", hue_saturation},
    {"gamma", gamma},
    {"invert", invert},
    {"bright_contrast", bright_contrast},
    {"luminance", convert<luminance>},
    {"hsv_from_rgb", convert<hsv_from_rgb>},
    {"rgb_from_hsv", convert<rgb_from_hsv>},
    {"hsl_from_rgb", convert<hsl_from_rgb>},
    {"rgb_from_hsl", convert<rgb_from_hsl>},
    {"ramp", ramp, true, DataKind::kRamp},
    {"curves", curves, true, DataKind::kCurves},
};

}  // namespace

std::span<const NamedOperation> colour_operations() {
  return kOperations;
}

}  // namespace penumbra
