// SPDX-License-Identifier: GPL-3.0-or-later
#include "material/lobes.h"

#include <cmath>
#include <numbers>

namespace penumbra {
namespace {

constexpr float kPi = std::numbers::pi_v<float>;

float square(float x) {
  return x * x;
}

/// Schlick's (1 - cos)^5.
float schlick(float cosine) {
  const float m = std::clamp(1 - cosine, 0.0f, 1.0f);
  return square(square(m)) * m;
}

/// Smith's masking for GGX, one direction.
float masking(float alpha_squared, float cosine) {
  return 2 / (1 + std::sqrt(1 + alpha_squared * (1 - square(cosine)) / square(cosine)));
}

float ggx_distribution(float a2, float cos_half) {
  return a2 / (kPi * square(square(cos_half) * (a2 - 1) + 1));
}

/// Heitz 2014, "Understanding the masking-shadowing function", eq. 99.
float correlated_ggx(float alpha, float cos_half, float cos_view, float cos_light) {
  const float a2 = square(alpha);
  const float g = 1 / (1 / masking(a2, cos_view) + 1 / masking(a2, cos_light) - 1);
  return ggx_distribution(a2, cos_half) * g / (4 * cos_view * cos_light);
}

/// Walter et al. 2007: D G / (4 cos cos'), eq. 20, 33 and 34.
float ggx(float alpha, float cos_half, float cos_view, float cos_light) {
  const float a2 = square(alpha);
  return ggx_distribution(a2, cos_half) * masking(a2, cos_view) * masking(a2, cos_light) /
         (4 * cos_view * cos_light);
}

/// Walter et al. 2007, eq. 25 and the rational approximation of eq. 27.
float beckmann_masking(float alpha, float cosine) {
  const float tangent = std::sqrt(std::max(1 - square(cosine), 0.0f)) / cosine;
  if (tangent == 0) return 1;
  const float a = 1 / (alpha * tangent);
  return a >= 1.6f ? 1 : a * (3.535f + 2.181f * a) / (1 + a * (2.276f + 2.577f * a));
}

float beckmann(float alpha, float cos_half, float cos_view, float cos_light) {
  const float a2 = square(alpha), c2 = square(cos_half);
  if (c2 == 0) return 0;
  const float d = std::exp((c2 - 1) / (c2 * a2)) / (kPi * a2 * square(c2));
  return d * beckmann_masking(alpha, cos_view) * beckmann_masking(alpha, cos_light) /
         (4 * cos_view * cos_light);
}

/// Burley 2012: the GTR1 distribution, with the masking of alpha = 0.25 whatever its own.
float clearcoat(float alpha, float cos_half, float cos_view, float cos_light) {
  constexpr float kMaskingAlphaSquared = 0.0625f;
  const float a2 = square(alpha);
  const float d = alpha >= 1 ? 1 / kPi : (a2 - 1) / (kPi * std::log(a2) * (1 + (a2 - 1) * square(cos_half)));
  return d * masking(kMaskingAlphaSquared, cos_view) * masking(kMaskingAlphaSquared, cos_light) /
         (4 * cos_view * cos_light);
}

/// Oren and Nayar 1994 in the form of Fujii's improved model.
struct OrenNayar {
  float sigma, scale;  // pi x BRDF where viewer and light are opposite each other

  explicit OrenNayar(float roughness)
      : sigma(roughness), scale(1 / (1 + (0.5f - 2 / (3 * kPi)) * roughness)) {}

  /// pi x BRDF.
  float operator()(float cos_view, float cos_light, float view_light) const {
    float t = view_light - cos_light * cos_view;
    if (t > 0) t /= std::max(cos_light, cos_view);
    return scale * (1 + sigma * t);
  }

  /// Share of the light from this angle that is reflected at once (Portsmouth, Kutz and Hill 2024, "EON", eq.
  /// 17).
  float albedo(float cosine) const {
    const float c = std::clamp(cosine, 1e-6f, 1.0f), s = std::sqrt(std::max(1 - c * c, 0.0f));
    const float g = s * (std::acos(c) - s * c) + 2.0f / 3 * ((s / c) * (1 - s * s * s) - s);
    return scale * (1 + sigma / kPi * g);
  }

  /// The mean of albedo() over all directions, weighted with the cosine.
  float mean_albedo() const { return scale * (1 + sigma * (2.0f / 3 - 28 / (15 * kPi))); }
};

/// Burley 2012, pi x BRDF.
float disney(float roughness, float cos_view, float cos_light, float view_light) {
  const float fv = schlick(cos_view), fl = schlick(cos_light), retro = roughness * (view_light + 1);
  return (1 - fv / 2) * (1 - fl / 2) + retro * (fl + fv + fl * fv * (retro - 1));
}

}  // namespace

float fresnel_dielectric(float cosine, float ior) {
  const float c = std::abs(cosine), g2 = ior * ior - 1 + c * c;
  if (g2 <= 0) return 1;  // total reflection
  const float g = std::sqrt(g2), a = (g - c) / (g + c), b = (c * (g + c) - 1) / (c * (g - c) + 1);
  return 0.5f * a * a * (1 + b * b);
}

float fresnel_edge(float cosine, float ior) {
  if (ior < 0) return schlick(cosine);
  const float normal = square((ior - 1) / (ior + 1));
  return normal < 1 ? (fresnel_dielectric(cosine, ior) - normal) / (1 - normal) : 1;
}

float bump_shadowing(const Vec3f& smooth, const Vec3f& bumped, const Vec3f& to_light) {
  const float divisor = dot(bumped, to_light) * dot(smooth, bumped);
  const float g = divisor != 0 ? dot(smooth, to_light) / divisor : 0;
  return g >= 1 ? 1 : g < 0 ? 0 : g + g * g - g * g * g;
}

float facet_bump_shadowing(const Vec3f& smooth, const Vec3f& bumped, const Vec3f& to_light) {
  const float cosine = dot(smooth, to_light), deviation = dot(smooth, bumped);
  if (cosine * deviation <= 0) return 0;  // the light is at the surface's other side
  const float alpha_squared = std::clamp(0.125f * (1 / square(deviation) - 1), 0.0f, 1.0f);
  return std::min(masking(alpha_squared, std::abs(cosine)), 1.0f);
}

Vec3f oren_nayar_edge(const Vec3f& colour, const Vec3f& albedo, float roughness) {
  const float mean = OrenNayar(roughness).mean_albedo(), lost = 1 - mean;
  const auto factor = [&](float c) {
    c = c > 0 ? std::min(c, 1.0f) : 0;
    // Two bounces have the square of the albedo, and Cycles multiplies that with the closure's colour: one
    // factor more than EON's eq. 24 (seen in 4.3.2 and 5.2.2 by comparing albedos of 0.1 to 1; guarded by
    // "rough diffuse" against Cycles).
    return c * c * mean / (lost * (1 - c * lost));
  };
  return colour * Vec3f{factor(albedo.x), factor(albedo.y), factor(albedo.z)};
}

LobeValue evaluate_lobe(const Lobe& lobe, const ShadingPoint& point, const Vec3f& to_light) {
  const float cos_light = dot(point.normal, to_light), cos_view = dot(point.normal, point.view);
  // A bumped diffuse surface is lit where its normal looks away from the viewer, too.
  if (cos_light <= 0 || (cos_view <= 0 && !is_diffuse(lobe.kind))) return {0, 0};
  const Closures& m = point.material;
  float bump = 1;
  if (is_diffuse(lobe.kind) && m.bumped)
    bump = (m.facet_bumps ? facet_bump_shadowing : bump_shadowing)(m.smooth_normal, point.normal, to_light);
  const float view_light = dot(point.view, to_light);
  const Vec3f half = normalize(point.view + to_light);
  const float cos_half = dot(point.normal, half), cos_difference = dot(to_light, half);
  switch (lobe.kind) {
    case LobeKind::kLambert:
      return {bump, 0};
    case LobeKind::kOrenNayar: {
      const OrenNayar model(lobe.roughness);
      const float once = model(std::max(cos_view, 0.0f), cos_light, view_light);
      if (max_abs(lobe.edge) == 0) return {bump * once, 0};
      const float again = (1 - model.albedo(cos_view)) * (1 - model.albedo(cos_light));
      return {bump * (once + again), again / (once + again)};
    }
    case LobeKind::kDisney:
      return {bump * disney(lobe.roughness, cos_view, cos_light, view_light), 0};
    case LobeKind::kSheen:
      return {bump * kPi * schlick(cos_difference), 0};
    case LobeKind::kGgx:
    case LobeKind::kCorrelatedGgx:
    case LobeKind::kBeckmann:
    case LobeKind::kClearcoat: {
      constexpr float (*kMicrofacets[])(float, float, float, float) = {ggx, correlated_ggx, beckmann,
                                                                       clearcoat};
      const auto f = kMicrofacets[int(lobe.kind) - int(LobeKind::kGgx)];
      const float edge = lobe.ior != 0 ? fresnel_edge(cos_difference, lobe.ior) : 0.0f;
      return {kPi * f(lobe.roughness, cos_half, cos_view, cos_light), edge};
    }
  }
  return {0, 0};
}

}  // namespace penumbra
