// SPDX-License-Identifier: GPL-3.0-or-later
// Angles without branches, for loops that the compiler vectorises.
#pragma once

#include <cmath>

namespace penumbra {

/// atan2(y, x) for y >= 0, in [0, pi]; relative error below 1e-12 (tests/native/test_form_factor.cpp).
/// NaN where both are 0. atan(q) / q is a polynomial in q^2 through the Chebyshev nodes of [0, tan^2(pi/8)],
/// where atan(q) = pi/4 + atan((q - 1) / (q + 1)) brings larger q.
inline double angle_of(double y, double x) {
  constexpr double kQuarterPi = 0.78539816339744831, kTangent = 0.41421356237309503;  // tan(pi/8)
  constexpr double kC[] = {1.0,
                           -0.33333333330806214,
                           0.1999999960523096,
                           -0.14285690440033622,
                           0.11110385431163826,
                           -0.09078397054187842,
                           0.0756373922476908,
                           -0.05874638613642734,
                           0.030664456422545335};
  const double width = std::abs(x);
  const double low = y < width ? y : width, high = y < width ? width : y;
  const bool steep = low > kTangent * high;
  const double q = (steep ? low - high : low) / (steep ? low + high : high);
  const double z = q * q;
  double p = kC[8];
  for (int k = 7; k >= 0; --k) p = p * z + kC[k];
  double angle = q * p + (steep ? kQuarterPi : 0.0);
  angle = y < width ? angle : 2 * kQuarterPi - angle;
  return x < 0 ? 4 * kQuarterPi - angle : angle;
}

}  // namespace penumbra
