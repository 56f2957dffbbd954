// SPDX-License-Identifier: GPL-3.0-or-later
// Operations on numbers: the Math, Clamp and Map Range nodes. Names after the dot are Blender's own.
#include <cmath>
#include <limits>

#include "material/machine.h"

namespace penumbra {
namespace {

constexpr float kRadian = 0.017453292519943295f;

/// An operation that makes one number of three.
template <auto F>
void number(Machine& m, const Operation& o) {
  m.set(o, F(m.number(o, 0), m.number(o, 1), m.number(o, 2)));
}

float divide(float a, float b) {
  return b != 0 ? a / b : 0;
}

/// Only whole powers of negative numbers are numbers.
float power(float a, float b) {
  return a < 0 && b != std::floor(b) ? 0 : std::pow(a, b);
}

float logarithm(float a, float b) {
  return a <= 0 || b <= 0 ? 0 : divide(std::log(a), std::log(b));
}

float wrap(float value, float high, float low) {
  const float range = high - low;
  return range != 0 ? value - range * std::floor((value - low) / range) : low;
}

float pingpong(float a, float scale) {
  if (scale == 0) return 0;
  const float t = (a - scale) / (scale * 2);
  return std::abs((t - std::floor(t)) * scale * 2 - scale);
}

float smooth_minimum(float a, float b, float k) {
  if (k == 0) return std::min(a, b);
  const float h = std::max(k - std::abs(a - b), 0.0f) / k;
  return std::min(a, b) - h * h * h * k / 6;
}

float compare(float a, float b, float epsilon) {
  return a == b || std::abs(a - b) <= std::max(epsilon, std::numeric_limits<float>::epsilon()) ? 1.0f : 0.0f;
}

// Named, since GCC takes a > in a lambda among template arguments for their end.
float greater_than(float a, float b, float) {
  return a > b ? 1.0f : 0.0f;
}
float inverse_root(float a, float, float) {
  return a > 0 ? 1 / std::sqrt(a) : 0;
}

float sign(float a) {
  return a < 0 ? -1.0f : a > 0 ? 1.0f : 0.0f;
}

float clamp_between(float value, float low, float high) {
  return std::min(std::max(value, low), high);
}

float clamp_range(float value, float a, float b) {
  return a > b ? clamp_between(value, b, a) : clamp_between(value, a, b);
}

/// Where a value lies between two others.
float part(float value, float from, float to) {
  return divide(value - from, to - from);
}

float smoothstep(float x) {
  const float t = clamp_between(x, 0, 1);
  return (3 - 2 * t) * t * t;
}

float smootherstep(float x) {
  const float t = clamp_between(x, 0, 1);
  return t * t * t * (t * (t * 6 - 15) + 10);
}

/// Inputs: value, from min, from max, to min, to max, steps; by component, so that it serves vectors, too.
template <auto Shape>
void map_range(Machine& m, const Operation& o) {
  const auto one = [&](int i) {
    const float from = m.in(o, 1)[i], to = m.in(o, 2)[i], low = m.in(o, 3)[i], high = m.in(o, 4)[i];
    if (from == to) return 0.0f;
    return low + Shape(part(m.in(o, 0)[i], from, to), m.in(o, 5)[i]) * (high - low);
  };
  m.set(o, Vec3f{one(0), one(1), one(2)});
}

constexpr auto kLinear = [](float t, float) { return t; };
constexpr auto kStepped = [](float t, float steps) {
  return steps > 0 ? std::floor(t * (steps + 1)) / steps : 0.0f;
};
constexpr auto kSmooth = [](float t, float) { return smoothstep(t); };
constexpr auto kSmoother = [](float t, float) { return smootherstep(t); };

void clamp_vector_range(Machine& m, const Operation& o) {
  const Vec3f &v = m.in(o, 0), &a = m.in(o, 1), &b = m.in(o, 2);
  m.set(o, Vec3f{clamp_range(v.x, a.x, b.x), clamp_range(v.y, a.y, b.y), clamp_range(v.z, a.z, b.z)});
}

constexpr NamedOperation kOperations[] = {
    {"math.ADD", number<[](float a, float b, float) { return a + b; }>},
    {"math.SUBTRACT", number<[](float a, float b, float) { return a - b; }>},
    {"math.MULTIPLY", number<[](float a, float b, float) { return a * b; }>},
    {"math.DIVIDE", number<[](float a, float b, float) { return divide(a, b); }>},
    {"math.MULTIPLY_ADD", number<[](float a, float b, float c) { return a * b + c; }>},
    {"math.POWER", number<[](float a, float b, float) { return power(a, b); }>},
    {"math.LOGARITHM", number<[](float a, float b, float) { return logarithm(a, b); }>},
    {"math.SQRT", number<[](float a, float, float) { return std::sqrt(std::max(a, 0.0f)); }>},
    {"math.INVERSE_SQRT", number<inverse_root>},
    {"math.ABSOLUTE", number<[](float a, float, float) { return std::abs(a); }>},
    {"math.EXPONENT", number<[](float a, float, float) { return std::exp(a); }>},
    {"math.MINIMUM", number<[](float a, float b, float) { return std::min(a, b); }>},
    {"math.MAXIMUM", number<[](float a, float b, float) { return std::max(a, b); }>},
    {"math.LESS_THAN", number<[](float a, float b, float) { return greater_than(b, a, 0); }>},
    {"math.GREATER_THAN", number<greater_than>},
    {"math.SIGN", number<[](float a, float, float) { return sign(a); }>},
    {"math.COMPARE", number<compare>},
    {"math.SMOOTH_MIN", number<smooth_minimum>},
    {"math.SMOOTH_MAX", number<[](float a, float b, float k) { return -smooth_minimum(-a, -b, k); }>},
    {"math.ROUND", number<[](float a, float, float) { return std::floor(a + 0.5f); }>},
    {"math.FLOOR", number<[](float a, float, float) { return std::floor(a); }>},
    {"math.CEIL", number<[](float a, float, float) { return std::ceil(a); }>},
    {"math.TRUNC", number<[](float a, float, float) { return std::trunc(a); }>},
    {"math.FRACT", number<[](float a, float, float) { return a - std::floor(a); }>},
    {"math.MODULO", number<[](float a, float b, float) { return b != 0 ? std::fmod(a, b) : 0; }>},
    {"math.FLOORED_MODULO",
     number<[](float a, float b, float) { return b != 0 ? a - std::floor(a / b) * b : 0; }>},
    {"math.WRAP", number<wrap>},
    {"math.SNAP", number<[](float a, float b, float) { return std::floor(divide(a, b)) * b; }>},
    {"math.PINGPONG", number<[](float a, float b, float) { return pingpong(a, b); }>},
    {"math.SINE", number<[](float a, float, float) { return std::sin(a); }>},
    {"math.COSINE", number<[](float a, float, float) { return std::cos(a); }>},
    {"math.TANGENT", number<[](float a, float, float) { return std::tan(a); }>},
    {"math.ARCSINE", number<[](float a, float, float) { return std::asin(clamp_between(a, -1, 1)); }>},
    {"math.ARCCOSINE", number<[](float a, float, float) { return std::acos(clamp_between(a, -1, 1)); }>},
    {"math.ARCTANGENT", number<[](float a, float, float) { return std::atan(a); }>},
    {"math.ARCTAN2", number<[](float a, float b, float) { return std::atan2(a, b); }>},
    {"math.SINH", number<[](float a, float, float) { return std::sinh(a); }>},
    {"math.COSH", number<[](float a, float, float) { return std::cosh(a); }>},
    {"math.TANH", number<[](float a, float, float) { return std::tanh(a); }>},
    {"math.RADIANS", number<[](float a, float, float) { return a * kRadian; }>},
    {"math.DEGREES", number<[](float a, float, float) { return a / kRadian; }>},
    {"clamp.MINMAX", number<clamp_between>},
    {"clamp.RANGE", number<clamp_range>},
    {"clamp.vector_range", clamp_vector_range},
    {"map_range.LINEAR", map_range<kLinear>},
    {"map_range.STEPPED", map_range<kStepped>},
    {"map_range.SMOOTHSTEP", map_range<kSmooth>},
    {"map_range.SMOOTHERSTEP", map_range<kSmoother>},
};

}  // namespace

std::span<const NamedOperation> math_operations() {
  return kOperations;
}

}  // namespace penumbra
