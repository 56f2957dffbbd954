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

/// as_points(), as_bulbs() and by_four_points() of one element for many receivers.
PENUMBRA_VECTORIZED
void from_each(const float* element, float element_power, const ReceiverColumns& receivers, float* out,
               int* state) {
  const float cx = element[kCentre], cy = element[kCentre + 1], cz = element[kCentre + 2],
              nx = element[kNormal], ny = element[kNormal + 1], nz = element[kNormal + 2],
              radius = element[kRadius], near_square = element[kNearSquare], far_square = element[kFarSquare],
              power = element_power;
  const bool omni = element[kOmni] > 0, two_sided = element[kTwoSided] > 0;
  const uint32_t count = receivers.count;
  alignas(64) float values[kBatch];
  alignas(64) int states[kBatch];
  for (uint32_t i = 0; i < count; ++i) {
    const float dx = cx - receivers.x[i], dy = cy - receivers.y[i], dz = cz - receivers.z[i];
    const float square = dx * dx + dy * dy + dz * dz;
    const float height = dx * receivers.normal_x[i] + dy * receivers.normal_y[i] + dz * receivers.normal_z[i];
    const float facing = -(dx * nx + dy * ny + dz * nz);
    const float side = two_sided ? std::abs(facing) : facing;
    const float inverse = 1 / square;
    const float flat = (height * inverse) * (side * inverse) * power;
    const float bulb = height / (square * std::sqrt(square)) * power;
    const bool sends = (omni ? square : side) > 0 && height > -radius;
    const bool near = height < radius || square < near_square;
    values[i] = sends && !near ? (omni ? bulb : flat) : 0.0f;
    states[i] = !sends                         ? kPointLight
                : near                         ? kNearLight
                : !omni && square < far_square ? kFourPoints
                                               : kPointLight;
  }
  for (uint32_t i = 0; i < count; ++i) out[i] = values[i];
  for (uint32_t i = 0; i < count; ++i) state[i] = states[i];
}

PENUMBRA_VECTORIZED
void four_from_each(const float* element, float element_power, const ReceiverColumns& receivers,
                    const int* state, float* out) {
  float e[kRadius];
  for (int k = 0; k < kRadius; ++k) e[k] = element[k];
  const float power = element_power;
  const uint32_t count = receivers.count;
  alignas(64) float values[kBatch];
  for (uint32_t i = 0; i < count; ++i) {
    const float dx = e[kCentre] - receivers.x[i], dy = e[kCentre + 1] - receivers.y[i],
                dz = e[kCentre + 2] - receivers.z[i];
    const float facing = -(dx * e[kNormal] + dy * e[kNormal + 1] + dz * e[kNormal + 2]);
    float sum = 0;
    for (int k = 0; k < 4; ++k) {
      const float s = k & 1 ? 1.0f : -1.0f, t = k & 2 ? 1.0f : -1.0f;
      const float x = dx + s * e[kHalfU] + t * e[kHalfV], y = dy + s * e[kHalfU + 1] + t * e[kHalfV + 1],
                  z = dz + s * e[kHalfU + 2] + t * e[kHalfV + 2];
      const float square = x * x + y * y + z * z;
      sum += (x * receivers.normal_x[i] + y * receivers.normal_y[i] + z * receivers.normal_z[i]) /
             (square * square);
    }
    values[i] = 0.25f * sum * std::abs(facing) * power;
  }
  for (uint32_t i = 0; i < count; ++i) out[i] = state[i] == kFourPoints ? values[i] : out[i];
}

/// Adds each element as one point, or as four, lane by lane.
PENUMBRA_VECTORIZED
void sum_vectors(const float* const* columns, uint32_t count, const float* powers, const Receiver& receiver,
                 bool four, float* sums) {
  constexpr uint32_t kLanes = 16;
  const Receiver g = receiver;
  const float *cx = columns[kCentre], *cy = columns[kCentre + 1], *cz = columns[kCentre + 2],
              *nx = columns[kNormal], *ny = columns[kNormal + 1], *nz = columns[kNormal + 2],
              *ux = columns[kHalfU], *uy = columns[kHalfU + 1], *uz = columns[kHalfU + 2],
              *vx = columns[kHalfV], *vy = columns[kHalfV + 1], *vz = columns[kHalfV + 2],
              *two_sided = columns[kTwoSided], *omni = columns[kOmni];
  const int points = four ? 4 : 1;
  const float part = four ? 0.25f : 1.0f, half = four ? 1.0f : 0.0f;
  float lanes[3][kLanes] = {};
  for (uint32_t begin = 0; begin < count; begin += kLanes) {
    for (int p = 0; p < points; ++p) {
      const float s = p & 1 ? half : -half, t = p & 2 ? half : -half;
      for (uint32_t k = 0; k < kLanes; ++k) {
        const uint32_t i = begin + k;
        const float dx = cx[i] - g.point.x + s * ux[i] + t * vx[i],
                    dy = cy[i] - g.point.y + s * uy[i] + t * vy[i],
                    dz = cz[i] - g.point.z + s * uz[i] + t * vz[i];
        const float square = dx * dx + dy * dy + dz * dz, inverse = 1 / square;
        const float facing = -(dx * nx[i] + dy * ny[i] + dz * nz[i]);
        const float side = two_sided[i] > 0 ? std::abs(facing) : facing;
        const bool is_omni = omni[i] > 0;
        const float power = (is_omni || side > 0) ? part * powers[i] : 0.0f;
        const float a = power * (is_omni ? inverse * std::sqrt(inverse) : side * inverse * inverse);
        lanes[0][k] += a * dx, lanes[1][k] += a * dy, lanes[2][k] += a * dz;
      }
    }
  }
  for (int c = 0; c < 3; ++c) {
    sums[c] = 0;
    for (uint32_t k = 0; k < kLanes; ++k) sums[c] += lanes[c][k];
  }
}

}  // namespace

Vec3d vector_sum(const std::vector<std::vector<float>>& columns, uint32_t first, uint32_t count, int channel,
                 const Vec3d& point, const Vec3d& middle) {
  // Whole lanes: elements without power fill the last one.
  alignas(64) float copies[kPower][kLightChunk], powers[kLightChunk] = {};
  const float* c[kPower];
  const uint32_t whole = (count + 15) / 16 * 16;
  for (uint32_t i = 0; i < kPower; ++i) {
    const float* column = columns[i].data() + first;
    c[i] = column;
    if (whole == count) continue;
    std::copy(column, column + count, copies[i]);
    std::fill(copies[i] + count, copies[i] + whole, column[0]);
    c[i] = copies[i];
  }
  const float* power = columns[size_t(kPower + channel)].data() + first;
  std::copy(power, power + count, powers);
  const Vec3f m(middle);
  bool four = false;
  for (uint32_t i = 0; i < count; ++i) {
    const float dx = c[kCentre][i] - m.x, dy = c[kCentre + 1][i] - m.y, dz = c[kCentre + 2][i] - m.z;
    four |= dx * dx + dy * dy + dz * dz < c[kFarSquare][i];
  }
  float sums[3];
  sum_vectors(c, whole, powers, {Vec3f(point), {}}, four, sums);
  return {double(sums[0]), double(sums[1]), double(sums[2])};
}

double turning_sum(const std::vector<std::vector<float>>& columns, uint32_t first, uint32_t count,
                   int channel, const Vec3d& point, double distance) {
  const Vec3f p(point);
  const float* powers = columns[size_t(kPower + channel)].data() + first;
  double sum = 0;
  for (uint32_t i = 0; i < count; ++i) {
    const auto at = [&](int column) { return columns[size_t(column)][first + i]; };
    const float height = (at(kCentre) - p.x) * at(kNormal) + (at(kCentre + 1) - p.y) * at(kNormal + 1) +
                         (at(kCentre + 2) - p.z) * at(kNormal + 2);
    if (at(kOmni) == 0 && std::abs(height) < float(distance)) sum += double(powers[i]);
  }
  return sum;
}

double formula_from(const LightElement& e) {
  return std::max(e.near, e.normal == Vec3d{} ? 0.0 : e.radius * kFarFour);
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
  const double near = formula_from(e), far = omni ? 0.0 : e.radius * kFarOne;
  const auto square = [](double x) { return float(std::min(x * x, 3e38)); };
  columns[kRadius].push_back(float(e.radius));
  columns[kNearSquare].push_back(square(near));
  columns[kFarSquare].push_back(square(far));
  columns[kOmni].push_back(omni ? 1.0f : 0.0f);
  columns[kTwoSided].push_back(e.two_sided ? 1.0f : 0.0f);
  for (int channel = 0; channel < 4; ++channel)
    columns[size_t(kPower + channel)].push_back(float(e.strength * double(radiance[channel])));
}

ReceiverColumns::ReceiverColumns(const SurfaceColumns& surfaces) : count(surfaces.count) {
  for (uint32_t i = 0; i < count; ++i) {
    x[i] = float(surfaces.x[i]), y[i] = float(surfaces.y[i]), z[i] = float(surfaces.z[i]);
    normal_x[i] = float(surfaces.normal_x[i]), normal_y[i] = float(surfaces.normal_y[i]),
    normal_z[i] = float(surfaces.normal_z[i]);
  }
}

bool far_light_each(const std::vector<std::vector<float>>& columns, uint32_t element, int channel,
                    const ReceiverColumns& receivers, float* out, int* state) {
  float e[kPower];
  for (size_t k = 0; k < kPower; ++k) e[k] = columns[k][element];
  const float power = columns[size_t(kPower + channel)][element];
  from_each(e, power, receivers, out, state);
  int most = 0, four = 0;
  for (uint32_t i = 0; i < receivers.count; ++i) {
    most = std::max(most, state[i]);
    four |= state[i] == kFourPoints;
  }
  if (four) four_from_each(e, power, receivers, state, out);
  return most == kNearLight;
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
