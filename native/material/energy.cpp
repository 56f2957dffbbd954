// SPDX-License-Identifier: GPL-3.0-or-later
#include "material/energy.h"

#include <array>
#include <cmath>
#include <numbers>

#include "material/lobes.h"
#include "sampling/hash.h"

namespace penumbra {
namespace {

/// Steps of the tables in cosine, roughness and index of refraction; points of each integral. Interpolated,
/// the albedo is within 0.003 of the integral with many points (tests/native/test_energy.cpp).
constexpr int kCosines = 24, kRoughnesses = 24, kIndices = 12, kPoints = 256;
constexpr float kLeastCosine = 0.02f, kLeastRoughness = 0.05f, kLowestIor = 1.01f, kHighestIor = 4;

/// Smith's lambda for GGX.
float lambda(float alpha, float cosine) {
  const float c2 = cosine * cosine;
  return (std::sqrt(1 + alpha * alpha * (1 - c2) / c2) - 1) / 2;
}

/// Mean over visible normals (Heitz 2018, "Sampling the GGX distribution of visible normals") of the light's
/// shadowing, given that the viewer sees it, times `reflectance` at the half-vector.
template <typename F>
float integrate(float cosine, float roughness, const F& reflectance) {
  const float alpha = roughness * roughness, sine = std::sqrt(1 - cosine * cosine);
  const Vec3f view{sine, 0, cosine}, stretched = normalize(Vec3f{alpha * sine, 0, cosine});
  float sum = 0;
  for (uint32_t i = 0; i < kPoints; ++i) {
    const float r = std::sqrt((float(i) + 0.5f) / kPoints);
    const float phi = 2 * std::numbers::pi_v<float> * float(reverse_bits(i)) * 0x1p-32f;
    const float t1 = r * std::cos(phi), s = (1 + stretched.z) / 2;
    const float t2 = (1 - s) * std::sqrt(1 - t1 * t1) + s * r * std::sin(phi);
    const float t3 = std::sqrt(std::max(0.0f, 1 - t1 * t1 - t2 * t2));
    // A frame about the stretched viewer: y, the other tangent, the viewer.
    const Vec3f tangent{-stretched.z, 0, stretched.x};
    const Vec3f n = Vec3f{0, 1, 0} * t1 + tangent * t2 + stretched * t3;
    const Vec3f half = normalize(Vec3f{alpha * n.x, alpha * n.y, std::max(n.z, 0.0f)});
    const Vec3f light = half * (2 * dot(view, half)) - view;
    if (light.z <= 0) continue;
    const float seen = 1 + lambda(alpha, cosine);
    sum += seen / (seen + lambda(alpha, light.z)) * reflectance(dot(view, half));
  }
  return sum / kPoints;
}

/// On the table's axis; no number counts as the least.
float position(float value, float low, float high, int steps) {
  const float share = (value - low) / (high - low);
  return (share > 0 ? std::min(share, 1.0f) : 0.0f) * float(steps - 1);
}
float at(int step, float low, float high, int steps) {
  return low + (high - low) * float(step) / float(steps - 1);
}

using Table = std::array<std::array<float, kCosines>, kRoughnesses>;

/// Linear in both.
float interpolated(const Table& table, float cosine, float roughness) {
  const float c = position(cosine, kLeastCosine, 1, kCosines),
              r = position(roughness, kLeastRoughness, 1, kRoughnesses);
  const int i = std::min(int(c), kCosines - 2), k = std::min(int(r), kRoughnesses - 2);
  const float s = c - float(i), t = r - float(k);
  const auto row = [&](int n) {
    return table[size_t(n)][size_t(i)] * (1 - s) + table[size_t(n)][size_t(i) + 1] * s;
  };
  return row(k) * (1 - t) + row(k + 1) * t;
}

template <typename F>
Table make_table(const F& reflectance) {
  Table table;
  for (int r = 0; r < kRoughnesses; ++r)
    for (int c = 0; c < kCosines; ++c)
      table[size_t(r)][size_t(c)] =
          integrate(at(c, kLeastCosine, 1, kCosines), at(r, kLeastRoughness, 1, kRoughnesses), reflectance);
  return table;
}

const Table& whole() {
  static const Table table = make_table([](float) { return 1.0f; });
  return table;
}

/// By index of refraction, each step as far from the last as its logarithm says.
const std::array<Table, kIndices>& dielectrics() {
  static const auto tables = [] {
    std::array<Table, kIndices> result;
    for (int i = 0; i < kIndices; ++i) {
      const float ior = std::exp(at(i, std::log(kLowestIor), std::log(kHighestIor), kIndices));
      result[size_t(i)] = make_table([ior](float cosine) { return fresnel_dielectric(cosine, ior); });
    }
    return result;
  }();
  return tables;
}

}  // namespace

float ggx_albedo(float cosine, float roughness) {
  return interpolated(whole(), cosine, roughness);
}

float mean_ggx_albedo(float roughness) {
  constexpr int kSteps = 16;
  float sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const float cosine = (float(i) + 0.5f) / kSteps;
    sum += 2 * cosine * ggx_albedo(cosine, roughness) / kSteps;
  }
  return sum;
}

float dielectric_albedo(float cosine, float roughness, float ior) {
  const float n =
      position(std::log(std::max(ior, kLowestIor)), std::log(kLowestIor), std::log(kHighestIor), kIndices);
  const int i = std::min(int(n), kIndices - 2);
  const auto& tables = dielectrics();
  const float t = n - float(i);
  return interpolated(tables[size_t(i)], cosine, roughness) * (1 - t) +
         interpolated(tables[size_t(i) + 1], cosine, roughness) * t;
}

}  // namespace penumbra
