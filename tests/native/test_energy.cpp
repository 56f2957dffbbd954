// SPDX-License-Identifier: GPL-3.0-or-later
// Albedos of lobes against their integral over light directions, by the lobe that lighting evaluates:
// two roads to the same number. The midpoint rule in 400 x 400 directions is good to 1e-3 from roughness 0.3
// on; the tables' interpolation adds 3e-3.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "material/energy.h"
#include "material/lobes.h"
#include "oracles.h"

namespace penumbra {
namespace {

using test::kPi;

/// Mean of the colour that a lobe reflects towards a viewer at this angle under white light from everywhere.
double integral(float cosine, const Lobe& lobe, float ior = 0) {
  const SurfacePoint surface{{}, {0, 0, 1}, {0, 0, 1}, 0, 0, 0};
  Closures closures;
  closures.add(lobe);
  const double sine = std::sqrt(1 - double(cosine) * double(cosine));
  const ShadingPoint point(surface, closures, {-sine, 0, -double(cosine)});
  constexpr int kSteps = 400;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double angle = (i + 0.5) / kSteps * kPi / 2,
                 weight = std::sin(angle) * std::cos(angle) * (kPi / 2 / kSteps);
    for (int k = 0; k < kSteps; ++k) {
      const double phi = 2 * kPi * (k + 0.5) / kSteps;
      const Vec3f light(
          Vec3d{std::sin(angle) * std::cos(phi), std::sin(angle) * std::sin(phi), std::cos(angle)});
      const float reflected =
          ior > 0 ? fresnel_dielectric(dot(light, normalize(light + point.view)), ior) : 1.0f;
      const Vec3f colour = coloured(lobe, evaluate_lobe(lobe, point, light));
      sum +=
          double(colour.x + colour.y + colour.z) / 3 * double(reflected) / kPi * weight * (2 * kPi / kSteps);
    }
  }
  return sum;
}

double integral(float cosine, float roughness, float ior) {
  Lobe lobe;
  lobe.kind = LobeKind::kCorrelatedGgx;
  lobe.colour = {1, 1, 1};
  lobe.roughness = roughness * roughness;
  return integral(cosine, lobe, ior);
}

TEST(Energy, GgxReflectsWhatItsIntegralSays) {
  for (const float cosine : {0.2f, 0.57f, 0.93f})
    for (const float roughness : {0.35f, 0.6f, 0.97f})
      EXPECT_NEAR(ggx_albedo(cosine, roughness), integral(cosine, roughness, 0), 6e-3)
          << cosine << " " << roughness;
}

TEST(Energy, DielectricsReflectWhatTheirIntegralSays) {
  for (const float cosine : {0.2f, 0.57f, 0.93f})
    for (const float ior : {1.2f, 1.5f, 2.3f})
      EXPECT_NEAR(dielectric_albedo(cosine, 0.5f, ior), integral(cosine, 0.5f, ior), 6e-3)
          << cosine << " " << ior;
}

TEST(Energy, SmoothMicrofacetsReflectEverything) {
  EXPECT_NEAR(ggx_albedo(0.7f, 0.0f), 1, 2e-3);
  EXPECT_NEAR(mean_ggx_albedo(0.0f), 1, 5e-3);
}

/// A shader's nodes can give anything. Found by fuzzing: NaN read far outside the tables.
TEST(Energy, ValuesThatAreNoNumbersStayInsideTheTables) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN(),
                  kInf = std::numeric_limits<float>::infinity();
  for (const float a : {kNan, kInf, -kInf, 0.5f})
    for (const float b : {kNan, kInf, -kInf, 0.5f}) {
      EXPECT_NEAR(ggx_albedo(a, b), 0.5, 0.51) << a << " " << b;
      EXPECT_NEAR(mean_ggx_albedo(b), 0.5, 0.51) << b;
      for (const float ior : {kNan, kInf, -kInf, -1.0f, 0.0f, 1.5f})
        EXPECT_NEAR(dielectric_albedo(a, b, ior), 0.5, 0.51) << a << " " << b << " " << ior;
    }
}

/// A white furnace: what bounces between the facets of a white surface comes out again, too.
TEST(Energy, RoughDiffuseOfWhiteLosesNothing) {
  for (const float cosine : {0.1f, 0.5f, 0.95f})
    for (const float roughness : {0.1f, 0.5f, 1.0f}) {
      Lobe lobe;
      lobe.kind = LobeKind::kOrenNayar;
      lobe.colour = {1, 1, 1};
      lobe.roughness = roughness;
      const double once = integral(cosine, lobe);
      lobe.edge = oren_nayar_edge(lobe.colour, lobe.colour, roughness);
      EXPECT_LT(once, 1 - 0.02 * double(roughness)) << cosine << " " << roughness;
      EXPECT_NEAR(integral(cosine, lobe), 1, 1e-3) << cosine << " " << roughness;
    }
}

}  // namespace
}  // namespace penumbra
