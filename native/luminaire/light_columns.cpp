// SPDX-License-Identifier: GPL-3.0-or-later
#include "luminaire/light_columns.h"

#include <algorithm>
#include <cmath>

#include "math/simd.h"

namespace penumbra {
namespace {

/// Distances, in radii, from which four points and one are good for 1e-3 of a facing light at worst, 5e-5 in
/// the mean: their first neglected terms are of fourth and of second order
/// (tests/native/test_light_tree.cpp).
constexpr double kFarFour = 8, kFarOne = 40;

/// Omni: 1 where there is no normal. Power: strength x |radiance|, four channels.
enum Column {
  kCentre,
  kNormal = 3,
  kHalfU = 6,
  kHalfV = 9,
  kRadius = 12,
  kNearSquare,
  kFarSquare,
  kOmni,
  kTwoSided,
  kPower
};
static_assert(kPower + 4 == kLightColumns);

struct Receiver {
  Vec3f point, normal;
};

PENUMBRA_VECTORIZED
void as_points(const float* const* columns, uint32_t count, const float* powers, const Receiver& receiver,
               float* out, int* state) {
  const Receiver g = receiver;
  const float* const c[kPower] = {columns[0],  columns[1],  columns[2],  columns[3],  columns[4],
                                  columns[5],  columns[6],  columns[7],  columns[8],  columns[9],
                                  columns[10], columns[11], columns[12], columns[13], columns[14],
                                  columns[15], columns[16]};
  for (uint32_t i = 0; i < count; ++i) {
    const float dx = c[kCentre][i] - g.point.x, dy = c[kCentre + 1][i] - g.point.y,
                dz = c[kCentre + 2][i] - g.point.z;
    const float square = dx * dx + dy * dy + dz * dz;
    const float height = dx * g.normal.x + dy * g.normal.y + dz * g.normal.z;
    const float facing = -(dx * c[kNormal][i] + dy * c[kNormal + 1][i] + dz * c[kNormal + 2][i]);
    const float flat = c[kTwoSided][i] > 0 ? std::abs(facing) : facing;
    const float side = c[kOmni][i] > 0 ? std::sqrt(square) : flat;
    const float value = (height / square) * (side / square) * powers[i];
    const bool sends = side > 0 && height > -c[kRadius][i];
    const bool near = height < c[kRadius][i] || square < c[kNearSquare][i];
    out[i] = sends && !near ? value : 0.0f;
    state[i] = !sends                      ? kPointLight
               : near                      ? kNearLight
               : square < c[kFarSquare][i] ? kFourPoints
                                           : kPointLight;
  }
}

PENUMBRA_VECTORIZED
void by_four_points(const float* const* columns, uint32_t count, const float* powers,
                    const Receiver& receiver, const int* state, float* out) {
  const Receiver g = receiver;
  const float* const c[kRadius] = {columns[0], columns[1], columns[2], columns[3], columns[4],  columns[5],
                                   columns[6], columns[7], columns[8], columns[9], columns[10], columns[11]};
  for (uint32_t i = 0; i < count; ++i) {
    const float dx = c[kCentre][i] - g.point.x, dy = c[kCentre + 1][i] - g.point.y,
                dz = c[kCentre + 2][i] - g.point.z;
    // The same for all points of a flat element.
    const float facing = -(dx * c[kNormal][i] + dy * c[kNormal + 1][i] + dz * c[kNormal + 2][i]);
    float sum = 0;
    for (int k = 0; k < 4; ++k) {
      const float s = k & 1 ? 1.0f : -1.0f, t = k & 2 ? 1.0f : -1.0f;
      const float x = dx + s * c[kHalfU][i] + t * c[kHalfV][i],
                  y = dy + s * c[kHalfU + 1][i] + t * c[kHalfV + 1][i],
                  z = dz + s * c[kHalfU + 2][i] + t * c[kHalfV + 2][i];
      const float square = x * x + y * y + z * z;
      sum += (x * g.normal.x + y * g.normal.y + z * g.normal.z) / (square * square);
    }
    const float value = 0.25f * sum * std::abs(facing) * powers[i];
    out[i] = state[i] == kFourPoints ? value : out[i];
  }
}

}  // namespace

void add_light_columns(const LightElement& e, const float radiance[4],
                       std::vector<std::vector<float>>& columns) {
  const auto put = [&](int column, const Vec3d& v) {
    for (int axis = 0; axis < 3; ++axis) columns[size_t(column + axis)].push_back(float(v[axis]));
  };
  put(kCentre, e.centre);
  put(kNormal, e.normal);
  put(kHalfU, e.half_u);
  put(kHalfV, e.half_v);
  const bool omni = e.normal == Vec3d{};
  const double near = std::max(e.near, omni ? 0.0 : e.radius * kFarFour),
               far = omni ? 0.0 : e.radius * kFarOne;
  const auto square = [](double x) { return float(std::min(x * x, 3e38)); };
  columns[kRadius].push_back(float(e.radius));
  columns[kNearSquare].push_back(square(near));
  columns[kFarSquare].push_back(square(far));
  columns[kOmni].push_back(omni ? 1.0f : 0.0f);
  columns[kTwoSided].push_back(e.two_sided ? 1.0f : 0.0f);
  for (int channel = 0; channel < 4; ++channel)
    columns[size_t(kPower + channel)].push_back(float(e.strength * double(radiance[channel])));
}

bool far_light(const std::vector<std::vector<float>>& columns, uint32_t first, uint32_t count, int channel,
               const SurfacePoint& surface, float* out, int* state) {
  const float* c[kPower];
  for (size_t i = 0; i < kPower; ++i) c[i] = columns[i].data() + first;
  const float* powers = columns[size_t(kPower + channel)].data() + first;
  const Receiver receiver{Vec3f(surface.position), Vec3f(surface.normal)};
  as_points(c, count, powers, receiver, out, state);
  int most = 0, four = 0;
  for (uint32_t i = 0; i < count; ++i) {
    most = std::max(most, state[i]);
    four |= state[i] == kFourPoints;
  }
  if (four) by_four_points(c, count, powers, receiver, state, out);
  return most == kNearLight;
}

}  // namespace penumbra
