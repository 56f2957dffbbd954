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

/// As flat elements; those without a normal are done over by as_bulbs().
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
    const float side = c[kTwoSided][i] > 0 ? std::abs(facing) : facing;
    const float inverse = 1 / square;
    const float value = (height * inverse) * (side * inverse) * powers[i];
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
void as_bulbs(const float* const* columns, uint32_t count, const float* powers, const Receiver& receiver,
              float* out, int* state) {
  const Receiver g = receiver;
  const float *cx = columns[kCentre], *cy = columns[kCentre + 1], *cz = columns[kCentre + 2],
              *radius = columns[kRadius], *near_square = columns[kNearSquare], *omni = columns[kOmni];
  for (uint32_t i = 0; i < count; ++i) {
    const float dx = cx[i] - g.point.x, dy = cy[i] - g.point.y, dz = cz[i] - g.point.z;
    const float square = dx * dx + dy * dy + dz * dz;
    const float height = dx * g.normal.x + dy * g.normal.y + dz * g.normal.z;
    const float value = height / (square * std::sqrt(square)) * powers[i];
    const bool sends = square > 0 && height > -radius[i];
    const bool near = height < radius[i] || square < near_square[i];
    out[i] = omni[i] > 0 ? (sends && !near ? value : 0.0f) : out[i];
    state[i] = omni[i] > 0 ? (sends && near ? kNearLight : kPointLight) : state[i];
  }
}

PENUMBRA_VECTORIZED
float sum_of(const float* values) {
  float s[kLightChunk];
  for (uint32_t i = 0; i < kLightChunk; ++i) s[i] = values[i];
  for (uint32_t half = kLightChunk / 2; half; half /= 2)
    for (uint32_t i = 0; i < half; ++i) s[i] += s[i + half];
  return s[0];
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

constexpr int kFieldSums = 12;

/// Sums for a LightField, lane by lane: its value, then its gradients.
PENUMBRA_VECTORIZED
void sum_field(const float* const* columns, uint32_t count, const float* powers, const Receiver& receiver,
               float* sums) {
  constexpr uint32_t kLanes = 16;
  const Receiver g = receiver;
  const float *cx = columns[kCentre], *cy = columns[kCentre + 1], *cz = columns[kCentre + 2],
              *nx = columns[kNormal], *ny = columns[kNormal + 1], *nz = columns[kNormal + 2],
              *two_sided = columns[kTwoSided], *omni = columns[kOmni];
  float lanes[kFieldSums][kLanes] = {};
  for (uint32_t begin = 0; begin < count; begin += kLanes) {
    for (uint32_t k = 0; k < kLanes; ++k) {
      const uint32_t i = begin + k;
      const float dx = cx[i] - g.point.x, dy = cy[i] - g.point.y, dz = cz[i] - g.point.z;
      const float square = dx * dx + dy * dy + dz * dz, inverse = 1 / square;
      const float facing = -(dx * nx[i] + dy * ny[i] + dz * nz[i]);
      const bool turned = two_sided[i] > 0 && facing < 0;
      const bool is_omni = omni[i] > 0;
      const float side = turned ? -facing : facing;
      const bool sends = is_omni || side > 0;
      const float power = sends ? powers[i] : 0.0f;
      // d a, with a = side / r^4, or 1 / r^3 without a normal; the derivative of side is the normal.
      const float a = power * (is_omni ? inverse * std::sqrt(inverse) : side * inverse * inverse);
      const float steep = (is_omni ? 3.0f : 4.0f) * a * inverse;
      const float b = (turned ? -power : power) * inverse * inverse;
      const float gx = b * nx[i] + steep * dx, gy = b * ny[i] + steep * dy, gz = b * nz[i] + steep * dz;
      lanes[0][k] += a * dx, lanes[1][k] += a * dy, lanes[2][k] += a * dz;
      lanes[3][k] += gx * dx - a, lanes[4][k] += gx * dy, lanes[5][k] += gx * dz;
      lanes[6][k] += gy * dx, lanes[7][k] += gy * dy - a, lanes[8][k] += gy * dz;
      lanes[9][k] += gz * dx, lanes[10][k] += gz * dy, lanes[11][k] += gz * dz - a;
    }
  }
  for (int s = 0; s < kFieldSums; ++s) {
    sums[s] = 0;
    for (uint32_t k = 0; k < kLanes; ++k) sums[s] += lanes[s][k];
  }
}

}  // namespace

void add_field(const std::vector<std::vector<float>>& columns, uint32_t first, uint32_t count, int channel,
               const Vec3d& point, LightField& field) {
  // Whole lanes: elements without power fill the last one.
  constexpr uint32_t kUsed[] = {0, 1, 2, 3, 4, 5, kOmni, kTwoSided};
  alignas(64) float copies[kPower][kLightChunk], powers[kLightChunk] = {};
  const float* c[kPower] = {};
  for (uint32_t i : kUsed) {
    const float* column = columns[i].data() + first;
    std::copy(column, column + count, copies[i]);
    std::fill(copies[i] + count, copies[i] + kLightChunk, column[0]);
    c[i] = copies[i];
  }
  const float* column = columns[size_t(kPower + channel)].data() + first;
  std::copy(column, column + count, powers);
  float sums[kFieldSums];
  sum_field(c, (count + 15) / 16 * 16, powers, {Vec3f(point), {}}, sums);
  const auto vector = [&](int s) { return Vec3d{double(sums[s]), double(sums[s + 1]), double(sums[s + 2])}; };
  field.value += vector(0);
  for (int k = 0; k < 3; ++k) field.gradient[k] += vector(3 + 3 * k);
}

float sum_light(const float* values) {
  return sum_of(values);
}

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
  bool bulbs = false;
  for (uint32_t i = 0; i < count; ++i) bulbs = bulbs || c[kOmni][i] > 0;
  if (bulbs) as_bulbs(c, count, powers, receiver, out, state);
  int most = 0, four = 0;
  for (uint32_t i = 0; i < count; ++i) {
    most = std::max(most, state[i]);
    four |= state[i] == kFourPoints;
  }
  if (four) by_four_points(c, count, powers, receiver, state, out);
  return most == kNearLight;
}

}  // namespace penumbra
