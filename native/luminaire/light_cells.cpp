// SPDX-License-Identifier: GPL-3.0-or-later
#include "luminaire/light_cells.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "math/simd.h"
#include "sampling/hash.h"

namespace penumbra {
namespace {

/// Side of a cube in distances to the node: light as 1 / r^4 of an element at r is off by 5 (side / 2r)^3.
constexpr double kCubeSide = 0.2;

/// Fewer elements are sorted for each surface point anew.
constexpr uint32_t kWorthAChoice = 12;

/// Share of a node's power that may come from elements whose plane cuts the cube: their light has a kink.
constexpr double kMostTurning = 0.02;

/// Steps from -1 to 1 of the normals that share a choice.
constexpr int kNormalSteps = 8;

/// Chebyshev points of three: -a, 0, a.
const double kOuterPoint = std::sqrt(0.75);

/// The parabolas' weights at t in [-1, 1].
void weights(float t, float out[3]) {
  const auto a = float(kOuterPoint);
  out[0] = t * (t - a) / 1.5f;  // 2 a^2
  out[1] = 1 - t * t / 0.75f;
  out[2] = t * (t + a) / 1.5f;
}

PENUMBRA_VECTORIZED
void interpolate(const float (*values)[32], const float* x, const float* y, const float* z, float* out) {
  float weight[32];
  for (int i = 27; i < 32; ++i) weight[i] = 0;
  for (int k = 0; k < 3; ++k)
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 3; ++i) weight[9 * k + 3 * j + i] = z[k] * y[j] * x[i];
  for (int c = 0; c < 3; ++c) {
    float terms[32];
    for (int i = 0; i < 32; ++i) terms[i] = weight[i] * values[c][i];
    for (int half = 16; half; half /= 2)
      for (int i = 0; i < half; ++i) terms[i] += terms[i + half];
    out[c] = terms[0];
  }
}

int quantised(double x) {
  return int(std::lround((x + 1) * kNormalSteps));
}

}  // namespace

void LightChoice::fill(const LightTree& tree, uint32_t node, LightChannel channel,
                       const SurfacePoint& surface) {
  const LightNode& n = tree.node(node);
  begin_ = n.begin;
  values_.resize(n.end - n.begin);
  until_.resize(n.end - n.begin);
  tree.sum(n.begin, n.end, channel, surface, values_.data());
  add_up();
}

void LightChoice::fill(uint32_t begin, uint32_t count, const float* values, uint32_t stride) {
  begin_ = begin;
  values_.resize(count);
  until_.resize(count);
  for (size_t i = 0; i < count; ++i) values_[i] = values[i * stride];
  add_up();
}

void LightChoice::add_up() {
  double total = 0;
  for (size_t i = 0; i < values_.size(); ++i) until_[i] = total += double(values_[i]);
  uint32_t k = 0;
  for (uint32_t g = 0; g < kGuides; ++g) {
    while (k + 1 < until_.size() && until_[k] <= double(g) / kGuides * total) ++k;
    guide_[g] = k;
  }
}

uint32_t LightChoice::pick(double at, double& share, double& within) const {
  const double total = until_.back(), target = at * total;
  // `at` may be rounded to 1.
  size_t k = guide_[std::min(size_t(at * kGuides), size_t{kGuides - 1})];
  while (k + 1 < until_.size() && until_[k] <= target) ++k;
  const auto own = double(values_[k]);
  share = own > 0 ? own / total : 0;
  within = own > 0 ? std::clamp((target - (until_[k] - own)) / own, 0.0, 1 - 0x1p-24) : 0.5;
  return begin_ + uint32_t(k);
}

size_t LightCells::KeyHash::operator()(const Key& key) const {
  const uint64_t place = hash_of(uint64_t(key.x), uint64_t(key.y)) ^ uint64_t(key.z) * 0x9E3779B97F4A7C15u;
  return hash_of(place, uint64_t(key.node) << 32 | uint64_t(uint32_t(key.level << 16 ^ key.normal)));
}

bool LightCells::cube(uint32_t node, const Vec3d& point, Key& key, Vec3d& centre, double& side) const {
  const LightNode& n = tree_.node(node);
  const Vec3d half = n.bounds.extent() * 0.5, to_centre = n.bounds.centre() - point;
  const Vec3d outside{std::max(std::abs(to_centre.x) - half.x, 0.0),
                      std::max(std::abs(to_centre.y) - half.y, 0.0),
                      std::max(std::abs(to_centre.z) - half.z, 0.0)};
  const double distance = length(outside);
  if (!(distance * kCubeSide >= smallest_side_)) return false;
  const int level = std::ilogb(distance * kCubeSide);
  side = std::ldexp(1.0, level);
  // Nor are the nearest points of the cube too near for the formula.
  if (distance - side * std::sqrt(3.0) < n.near) return false;
  const auto index = [side](double x) { return int64_t(std::floor(x / side)); };
  key = {node, level, index(point.x), index(point.y), index(point.z), 0};
  centre = Vec3d{double(key.x) + 0.5, double(key.y) + 0.5, double(key.z) + 0.5} * side;
  return true;
}

Vec3d LightCells::Field::at(const Vec3d& t) const {
  float x[3], y[3], z[3], light[3];
  weights(float(t.x), x), weights(float(t.y), y), weights(float(t.z), z);
  interpolate(values, x, y, z, light);
  return {double(light[0]), double(light[1]), double(light[2])};
}

const LightCells::Field& LightCells::field(const Key& key, const Vec3d& centre, double side) {
  std::unique_ptr<Field>& found = fields_[key];
  if (found) return *found;
  found = std::make_unique<Field>();
  const double diagonal = 0.5 * side * std::sqrt(3.0);
  found->smooth = tree_.turning_power(key.node, channel_, centre, diagonal) <= kMostTurning;
  std::fill(&found->values[0][0], &found->values[0][0] + 3 * 32, 0.0f);
  for (int i = 0; found->smooth && i < 27; ++i) {
    const Vec3d step{double(i % 3 - 1), double(i / 3 % 3 - 1), double(i / 9 - 1)};
    const Vec3d light =
        tree_.vector_light(key.node, channel_, centre + step * (0.5 * side * kOuterPoint), centre);
    for (int c = 0; c < 3; ++c) found->values[c][i] = float(light[c]);
  }
  return *found;
}

double LightCells::form_factor(uint32_t node, const SurfacePoint& surface) {
  const LightNode& n = tree_.node(node);
  const auto one_by_one = [&] { return tree_.sum(n.begin, n.end, channel_, surface, nullptr); };
  if (n.end - n.begin < kWorthACube) return one_by_one();
  if (n.is_below(surface)) return 0;
  if (n.is_above(surface)) {
    if (!std::isfinite(smallest_side_)) return one_by_one();
    Key key;
    Vec3d centre;
    double side;
    if (cube(node, surface.position, key, centre, side)) {
      const Field& f = field(key, centre, side);
      if (f.smooth) return std::max(dot(surface.normal, f.at((surface.position - centre) * (2 / side))), 0.0);
    }
  }
  return n.is_leaf() ? one_by_one() : form_factor(node + 1, surface) + form_factor(n.right, surface);
}

bool LightCells::is_small() const {
  const LightNode& n = tree_.node(root_);
  return n.end - n.begin < kWorthACube;
}

void LightCells::form_factors(const SurfaceColumns& surfaces, double* out) {
  if (is_small()) {
    const LightNode& n = tree_.node(root_);
    alignas(64) float values[kWorthACube * kBatch];
    return tree_.sums(n.begin, n.end, channel_, surfaces, values, out);
  }
  for (uint32_t i = 0; i < surfaces.count; ++i) out[i] = form_factor(root_, surfaces.point(i));
}

const LightChoice* LightCells::choice(const SurfacePoint& surface) {
  const LightNode& n = tree_.node(root_);
  Key key;
  SurfacePoint middle = surface;
  double side;
  if (n.end - n.begin < kWorthAChoice || !n.is_above(surface) ||
      !cube(root_, surface.position, key, middle.position, side))
    return nullptr;
  const int q[3] = {quantised(surface.normal.x), quantised(surface.normal.y), quantised(surface.normal.z)};
  middle.normal =
      normalize(Vec3d{double(q[0]), double(q[1]), double(q[2])} * (1.0 / kNormalSteps) - Vec3d{1, 1, 1});
  // What the middle does not see would never be chosen.
  if (middle.normal == Vec3d{} || !n.is_above(middle)) return nullptr;
  key.normal = (q[0] * 64 + q[1]) * 64 + q[2];
  std::unique_ptr<LightChoice>& found = choices_[key];
  if (!found) {
    found = std::make_unique<LightChoice>();
    found->fill(tree_, root_, channel_, middle);
  }
  return found.get();
}

double shared_cube_side(std::span<const Vec3d> points) {
  std::set<std::array<double, 3>> places;  // two points in one place share every cube
  Box bounds;
  double reach = 0;
  for (const Vec3d& p : points) {
    if (!is_finite(p)) continue;
    places.insert({p.x, p.y, p.z});
    bounds.include(p);
    reach = std::max(reach, max_abs(p));
  }
  double smallest = std::numeric_limits<double>::infinity();
  if (places.size() < 4) return smallest;
  // Down to where the points' own rounding is as large as cubes.
  for (double side = std::ldexp(1.0, std::ilogb(max_component(bounds.extent()))); side > reach * 0x1p-52;
       side /= 2) {
    std::set<std::array<int64_t, 3>> cubes;
    for (const auto& [x, y, z] : places)
      cubes.insert(
          {int64_t(std::floor(x / side)), int64_t(std::floor(y / side)), int64_t(std::floor(z / side))});
    if (cubes.size() * 4 > places.size() * 3) return smallest;
    smallest = side;
  }
  return smallest;
}

}  // namespace penumbra
