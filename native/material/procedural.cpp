// SPDX-License-Identifier: GPL-3.0-or-later
// Textures by formula: Checker, Noise, Gradient.
#include <array>
#include <bit>
#include <cmath>
#include <numbers>

#include "material/machine.h"

namespace penumbra {
namespace {

/// The last steps of Bob Jenkins' lookup3 hash.
uint32_t finish(uint32_t a, uint32_t b, uint32_t c) {
  c = (c ^ b) - std::rotl(b, 14);
  a = (a ^ c) - std::rotl(c, 11);
  b = (b ^ a) - std::rotl(a, 25);
  c = (c ^ b) - std::rotl(b, 16);
  a = (a ^ c) - std::rotl(c, 4);
  b = (b ^ a) - std::rotl(a, 14);
  return (c ^ b) - std::rotl(b, 24);
}

/// lookup3 of N words.
template <size_t N>
uint32_t hash(const std::array<uint32_t, N>& k) {
  uint32_t a, b, c;
  a = b = c = 0xdeadbeef + (uint32_t(N) << 2) + 13;
  a += k[0];
  if constexpr (N > 1) b += k[1];
  if constexpr (N > 2) c += k[2];
  if constexpr (N > 3) {
    a = (a - c) ^ std::rotl(c, 4), c += b;
    b = (b - a) ^ std::rotl(a, 6), a += c;
    c = (c - b) ^ std::rotl(b, 8), b += a;
    a = (a - c) ^ std::rotl(c, 16), c += b;
    b = (b - a) ^ std::rotl(a, 19), a += c;
    c = (c - b) ^ std::rotl(b, 4), b += a;
    a += k[3];
  }
  return finish(a, b, c);
}

/// 0 ... 1.
float hash_of_floats(float x, float y) {
  return float(hash<2>({std::bit_cast<uint32_t>(x), std::bit_cast<uint32_t>(y)})) * (1.0f / 4294967295.0f);
}

float negated_if(float value, uint32_t condition) {
  return condition ? -value : value;
}

/// The lattice's gradient, chosen by the hash, times the way from the lattice point: Perlin 2002.
template <size_t N>
float gradient(uint32_t h, const std::array<float, N>& p) {
  if constexpr (N == 1) {
    return negated_if(float(1 + (h & 7)), h & 8) * p[0];
  } else if constexpr (N == 2) {
    h &= 7;
    const float u = h < 4 ? p[0] : p[1], v = 2 * (h < 4 ? p[1] : p[0]);
    return negated_if(u, h & 1) + negated_if(v, h & 2);
  } else if constexpr (N == 3) {
    h &= 15;
    const float u = h < 8 ? p[0] : p[1], v = h < 4 ? p[1] : h == 12 || h == 14 ? p[0] : p[2];
    return negated_if(u, h & 1) + negated_if(v, h & 2);
  } else {
    h &= 31;
    const float u = h < 24 ? p[0] : p[1], v = h < 16 ? p[1] : p[2], s = h < 8 ? p[2] : p[3];
    return negated_if(u, h & 1) + negated_if(v, h & 2) + negated_if(s, h & 4);
  }
}

float fade(float t) {
  return t * t * t * (t * (t * 6 - 15) + 10);
}

/// Perlin noise, about -1 ... 1, by the scales of the authors of Open Shading Language.
template <size_t N>
float perlin(const std::array<float, N>& p) {
  constexpr float kScale[] = {0.2500f, 0.6616f, 0.9820f, 0.8344f};
  std::array<uint32_t, N> cell;
  std::array<float, N> inside;
  for (size_t i = 0; i < N; ++i) {
    const float whole = std::floor(p[i]);
    if (!(std::abs(whole) < 2e9f)) return 0;  // no lattice out there
    cell[i] = uint32_t(int32_t(whole));
    inside[i] = p[i] - whole;
  }
  std::array<float, size_t(1) << N> corners;
  for (uint32_t corner = 0; corner < corners.size(); ++corner) {
    std::array<uint32_t, N> at;
    std::array<float, N> from;
    for (size_t i = 0; i < N; ++i) {
      const uint32_t far = corner >> i & 1;
      at[i] = cell[i] + far;
      from[i] = inside[i] - float(far);
    }
    corners[corner] = gradient<N>(hash<N>(at), from);
  }
  for (size_t i = 0; i < N; ++i) {
    const float t = fade(inside[i]);
    for (size_t k = 0; k < corners.size() >> (i + 1); ++k)
      corners[k] = corners[2 * k] * (1 - t) + corners[2 * k + 1] * t;
  }
  return kScale[N - 1] * corners[0];
}

template <size_t N>
std::array<float, N> moved(std::array<float, N> p, float scale, float by_seed) {
  for (size_t i = 0; i < N; ++i)
    p[i] = p[i] * scale + (by_seed >= 0 ? 100 + 100 * hash_of_floats(by_seed, float(i)) : 0);
  return p;
}

template <>
std::array<float, 1> moved(std::array<float, 1> p, float scale, float by_seed) {
  const float h = float(hash<1>({std::bit_cast<uint32_t>(by_seed)})) * (1.0f / 4294967295.0f);
  return {p[0] * scale + (by_seed >= 0 ? 100 + 100 * h : 0)};
}

struct Fractal {
  float detail, roughness, lacunarity;
  bool normalize;

  /// Octaves of noise, the last one in part: fractal Brownian motion.
  template <size_t N>
  float value(const std::array<float, N>& p) const {
    float scale = 1, amplitude = 1, amplitudes = 0, sum = 0;
    const auto result = [&](float s, float a) { return normalize ? 0.5f * s / a + 0.5f : s; };
    for (int i = 0; i <= int(detail); ++i) {
      sum += perlin<N>(moved<N>(p, scale, -1)) * amplitude;
      amplitudes += amplitude;
      amplitude *= roughness;
      scale *= lacunarity;
    }
    const float rest = detail - std::floor(detail);
    if (rest == 0) return result(sum, amplitudes);
    const float more = sum + perlin<N>(moved<N>(p, scale, -1)) * amplitude;
    return result(sum, amplitudes) * (1 - rest) + result(more, amplitudes + amplitude) * rest;
  }
};

/// Inputs: vector, w, scale, detail, roughness, distortion, lacunarity. data: 1 where the result is
/// normalised.
template <size_t N>
void noise(Machine& m, const Operation& o) {
  const Vec3f v = m.in(o, 0) * m.number(o, 2);
  const float w = m.number(o, 1) * m.number(o, 2), distortion = m.number(o, 5);
  std::array<float, N> p;
  if constexpr (N == 1) p = {w};
  if constexpr (N == 2) p = {v.x, v.y};
  if constexpr (N == 3) p = {v.x, v.y, v.z};
  if constexpr (N == 4) p = {v.x, v.y, v.z, w};
  const auto number = [](float x, float high) { return x > 0 ? std::min(x, high) : 0.0f; };  // and not NaN
  const Fractal fractal{number(m.number(o, 3), 15), number(m.number(o, 4), 1e6f), m.number(o, 6),
                        o.data != 0};
  constexpr int kSeeds = N == 1 ? 1 : int(N);  // of the distortion; the colours' follow
  if (distortion != 0) {
    std::array<float, N> q = p;
    for (size_t i = 0; i < N; ++i) q[i] += distortion * perlin<N>(moved<N>(p, 1, float(i)));
    p = q;
  }
  const float value = fractal.template value<N>(p);
  m.set(o, value);
  m.set_second(o, Vec3f{value, fractal.template value<N>(moved<N>(p, 1, float(kSeeds))),
                        fractal.template value<N>(moved<N>(p, 1, float(kSeeds + 1)))});
}

/// Inputs: vector, two colours, scale. Slightly off the whole numbers, where rounding would decide.
void checker(Machine& m, const Operation& o) {
  const auto odd = [&](float x) {
    const float cell = std::floor((x * m.number(o, 3) + 0.000001f) * 0.999999f);
    return std::fmod(std::abs(cell), 2.0f) == 1;
  };
  const Vec3f& p = m.in(o, 0);
  const bool first = (odd(p.x) == odd(p.y)) == odd(p.z);
  m.set(o, first ? m.in(o, 1) : m.in(o, 2));
  m.set_second(o, first ? 1.0f : 0.0f);
}

template <auto F>
void gradient_texture(Machine& m, const Operation& o) {
  m.set(o, std::clamp(F(m.in(o, 0)), 0.0f, 1.0f));
}

float spherical(const Vec3f& p) {
  return std::max(0.999999f - length(p), 0.0f);
}
float eased(const Vec3f& p) {
  const float r = std::clamp(p.x, 0.0f, 1.0f);
  return 3 * r * r - 2 * r * r * r;
}
float radial(const Vec3f& p) {
  return std::atan2(p.y, p.x) / (2 * std::numbers::pi_v<float>)+0.5f;
}
float square_of_positive(float x) {
  return std::max(x, 0.0f) * std::max(x, 0.0f);
}

constexpr NamedOperation kOperations[] = {
    {"checker", checker},
    {"noise.1D", noise<1>},
    {"noise.2D", noise<2>},
    {"noise.3D", noise<3>},
    {"noise.4D", noise<4>},
    {"gradient.LINEAR", gradient_texture<[](const Vec3f& p) { return p.x; }>},
    {"gradient.QUADRATIC", gradient_texture<[](const Vec3f& p) { return square_of_positive(p.x); }>},
    {"gradient.EASING", gradient_texture<eased>},
    {"gradient.DIAGONAL", gradient_texture<[](const Vec3f& p) { return (p.x + p.y) / 2; }>},
    {"gradient.RADIAL", gradient_texture<radial>},
    {"gradient.SPHERICAL", gradient_texture<spherical>},
    {"gradient.QUADRATIC_SPHERE",
     gradient_texture<[](const Vec3f& p) { return square_of_positive(spherical(p)); }>},
};

}  // namespace

std::span<const NamedOperation> procedural_operations() {
  return kOperations;
}

}  // namespace penumbra
