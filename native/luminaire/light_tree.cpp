// SPDX-License-Identifier: GPL-3.0-or-later
#include "luminaire/light_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>

#include "luminaire/light_group.h"

namespace penumbra {
namespace {

/// Most leaves of a tree: scenes of more emissive triangles get larger leaves.
constexpr size_t kMostLeaves = 1 << 16;

/// A node is far beyond so many of its radii: its elements' light differs by less than their powers do.
constexpr double kFar = 4;

/// Radiances that differ by less, relatively, have the same hue.
constexpr double kSameHue = 1e-6;

/// cos(max(a - b, 0)) of two angles between 0 and pi, from their cosines and sines.
double cosine_of_difference(double cos_a, double sin_a, double cos_b, double sin_b) {
  return cos_a >= cos_b ? 1.0 : cos_a * cos_b + sin_a * sin_b;
}

double sine_of(double cosine) {
  return std::sqrt(std::max(1 - cosine * cosine, 0.0));
}

/// What the luminaires of a group have in common: shadows, what they light, the sign of their light, and the
/// pass that shows it.
using Kind = std::tuple<bool, bool, bool, RayMask, std::vector<bool>, bool, uint32_t>;

Kind kind_of(const Luminaire& luminaire) {
  const LuminaireRole& role = luminaire.role();
  return {luminaire.casts_shadow(), role.diffuse,   role.glossy,
          role.shadow_rays,         role.receivers, max_component(luminaire.radiance()) > 0,
          luminaire.light_group()};
}

}  // namespace

struct LightTree::Building {
  LightElement element;
  uint32_t luminaire, number;
  Vec3d radiance;  // not negative
};

double LightNode::height(const SurfacePoint& surface, int side) const {
  const Vec3d half = bounds.extent() * 0.5, n = surface.normal;
  const double reach = std::abs(half.x * n.x) + std::abs(half.y * n.y) + std::abs(half.z * n.z);
  return dot(bounds.centre() - surface.position, n) + side * reach;
}

Vec3d LightNode::bound(const SurfacePoint& surface) const {
  // What there is of the bounds above the horizon is no nearer, and no steeper, than the whole.
  if (is_below(surface)) return {};
  const Vec3d half = bounds.extent() * 0.5, to_centre = bounds.centre() - surface.position;
  const Vec3d n = surface.normal;
  const Vec3d outside{std::max(std::abs(to_centre.x) - half.x, 0.0),
                      std::max(std::abs(to_centre.y) - half.y, 0.0),
                      std::max(std::abs(to_centre.z) - half.z, 0.0)};
  const double nearest_square = dot(outside, outside);
  const double distance = length(to_centre), radius = length(half);
  double cosines = 1;
  if (distance > radius) {
    // Directions to the bounds lie within this angle of the one to the centre.
    const double sin_size = radius / distance, cos_size = sine_of(sin_size);
    const double cos_centre = dot(to_centre, n) / distance;
    cosines = std::max(cosine_of_difference(cos_centre, sine_of(cos_centre), cos_size, sin_size), 0.0);
    if (cosine > -1) {
      const double cos_axis = -dot(to_centre, axis) / distance, sin_axis = sine_of(cos_axis);
      // Away from the cone of normals, then from the bounds' own size.
      double c = cosine_of_difference(cos_axis, sin_axis, cosine, sine_of(cosine));
      c = cosine_of_difference(c, sine_of(c), cos_size, sin_size);
      cosines *= std::max(c, 0.0);
    }
  }
  if (cosines == 0) return {};
  if (nearest_square == 0) {
    const double infinity = std::numeric_limits<double>::infinity();
    return {power.x > 0 ? infinity : 0, power.y > 0 ? infinity : 0, power.z > 0 ? infinity : 0};
  }
  return power * (cosines / nearest_square);
}

LightTree::LightTree(std::vector<Luminaire> luminaires) : luminaires_(std::move(luminaires)) {
  std::map<Kind, std::vector<Building>> kinds;
  size_t count = 0;
  for (uint32_t l = 0; l < luminaires_.size(); ++l) {
    const Luminaire& luminaire = luminaires_[l];
    const Vec3d& r = luminaire.radiance();
    const bool negative = r.x < 0 || r.y < 0 || r.z<0, positive = r.x> 0 || r.y > 0 || r.z > 0;
    const std::vector<LightElement> elements = luminaire.elements();
    if (elements.empty() || (negative && positive)) {
      rest_.push_back(luminaire);
      continue;
    }
    auto& kind = kinds[kind_of(luminaire)];
    for (uint32_t i = 0; i < elements.size(); ++i) kind.push_back({elements[i], l, i, absolute(r)});
    count += elements.size();
  }
  largest_leaf_ = (count + kMostLeaves - 1) / kMostLeaves;
  columns_.assign(kLightColumns, {});
  for (auto& [key, elements] : kinds) add_root(elements);
}

void LightTree::add_root(std::vector<Building>& elements) {
  roots_.push_back(uint32_t(nodes_.size()));
  add_node(elements, uint32_t(sources_.size()));
  fill_columns(elements);
}

uint32_t LightTree::add_node(std::span<Building> elements, uint32_t begin) {
  const auto index = uint32_t(nodes_.size());
  LightNode node;
  node.begin = begin;
  node.end = begin + uint32_t(elements.size());
  Vec3d normals, hue;
  Box centres;
  bool any_direction = false;
  for (const Building& b : elements) {
    const LightElement& e = b.element;
    const Vec3d radius{e.radius, e.radius, e.radius};
    node.bounds.include(e.centre - radius);
    node.bounds.include(e.centre + radius);
    centres.include(e.centre);
    node.near = std::max(node.near, formula_from(e));
    node.power += b.radiance * e.strength;
    normals += e.normal;
    any_direction = any_direction || e.two_sided || e.two_sided_near || e.normal == Vec3d{};
    const Vec3d own = b.radiance / max_component(b.radiance);
    if (hue == Vec3d{}) hue = own;
    node.one_colour = node.one_colour && max_abs(own - hue) < kSameHue;
  }
  node.axis = normalize(normals);
  if (!any_direction && node.axis != Vec3d{}) {
    node.cosine = 1;
    // Rounding must not make the cone too narrow.
    for (const Building& b : elements)
      node.cosine = std::min(node.cosine, dot(node.axis, b.element.normal) - 1e-12);
    node.cosine = std::max(node.cosine, -1.0);
  }
  nodes_.push_back(node);
  if (elements.size() <= largest_leaf_) return index;

  const Vec3d extent = centres.extent();
  const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
  const size_t half = elements.size() / 2;
  std::nth_element(elements.begin(), elements.begin() + std::ptrdiff_t(half), elements.end(),
                   [axis](const Building& a, const Building& b) {
                     const double x = a.element.centre[axis], y = b.element.centre[axis];
                     if (x != y) return x < y;
                     return a.luminaire != b.luminaire ? a.luminaire < b.luminaire : a.number < b.number;
                   });
  add_node(elements.first(half), begin);
  const uint32_t right = add_node(elements.subspan(half), begin + uint32_t(half));
  nodes_[index].right = right;
  return index;
}

void LightTree::fill_columns(std::span<const Building> elements) {
  for (const Building& b : elements) {
    const Vec3d& r = b.radiance;
    const Source source{&luminaires_[b.luminaire].emitter(),
                        b.luminaire,
                        b.number,
                        b.element.u_begin,
                        b.element.u_end,
                        {float(max_component(r)), float(r.x), float(r.y), float(r.z)}};
    sources_.push_back(source);
    add_light_columns(b.element, source.radiance, columns_);
    for (size_t c = 0; c < power_until_.size(); ++c) {
      std::vector<double>& until = power_until_[c];
      until.push_back((until.empty() ? 0 : until.back()) + b.element.strength * double(source.radiance[c]));
    }
  }
}

uint32_t LightTree::count(uint32_t i) const {
  const LightNode& n = nodes_[i];
  return n.one_colour || n.end - n.begin == 1 ? 1 : 3;
}

void LightTree::append(uint32_t i, double smallest_side, std::vector<Luminaire>& out) const {
  const LightNode& n = nodes_[i];
  const Source& first = sources_[n.begin];
  const Luminaire& one = luminaires_[first.luminaire];
  bool alone = true;
  for (uint32_t e = n.begin; e < n.end; ++e) alone = alone && sources_[e].luminaire == first.luminaire;
  // Is it all of it, or some triangles of a mesh?
  if (alone && n.end - n.begin == one.elements().size()) {
    out.push_back(one);
    return;
  }
  const double sign = max_component(one.radiance()) > 0 ? 1 : -1;
  const std::string name = one.name() + (alone ? " (a part)" : " and others");
  const auto group = [&](LightChannel channel, const Vec3d& radiance) {
    out.emplace_back(name, std::make_shared<LightGroup>(*this, i, channel, smallest_side), radiance * sign,
                     one.casts_shadow(), one.role(), one.light_group());
  };
  if (n.one_colour) {
    group(LightChannel::kLargest, absolute(one.radiance()) / max_abs(one.radiance()));
    return;
  }
  if (n.power.x > 0) group(LightChannel::kRed, {1, 0, 0});
  if (n.power.y > 0) group(LightChannel::kGreen, {0, 1, 0});
  if (n.power.z > 0) group(LightChannel::kBlue, {0, 0, 1});
}

bool LightTree::is_far(uint32_t i, const SurfacePoint& surface) const {
  const LightNode& n = nodes_[i];
  const Vec3d half = n.bounds.extent() * 0.5, to_centre = n.bounds.centre() - surface.position;
  const double radius = length(half);
  return dot(to_centre, surface.normal) >= radius &&
         dot(to_centre, to_centre) >= kFar * kFar * radius * radius;
}

Vec3d LightTree::vector_light(uint32_t i, LightChannel channel, const Vec3d& point,
                              const Vec3d& middle) const {
  const LightNode& n = nodes_[i];
  Vec3d sum;
  for (uint32_t first = n.begin; first < n.end; first += kLightChunk)
    sum += vector_sum(columns_, first, std::min(kLightChunk, n.end - first), int(channel), point, middle);
  return sum;
}

double LightTree::turning_power(uint32_t i, LightChannel channel, const Vec3d& point, double distance) const {
  const LightNode& n = nodes_[i];
  const std::vector<double>& until = power_until_[size_t(channel)];
  const double total = until[n.end - 1] - (n.begin ? until[n.begin - 1] : 0);
  double turning = 0;
  for (uint32_t first = n.begin; first < n.end; first += kLightChunk)
    turning +=
        turning_sum(columns_, first, std::min(kLightChunk, n.end - first), int(channel), point, distance);
  return total > 0 ? turning / total : 0;
}

uint32_t LightTree::pick(uint32_t i, LightChannel channel, double at, double& share, double& within) const {
  const LightNode& n = nodes_[i];
  const std::vector<double>& until = power_until_[size_t(channel)];
  const double before = n.begin ? until[n.begin - 1] : 0, total = until[n.end - 1] - before;
  const double target = before + at * total;
  const auto first = until.begin() + n.begin, last = until.begin() + n.end - 1;
  const auto k = uint32_t(std::upper_bound(first, last, target) - until.begin());
  const double below = k ? until[k - 1] : 0, own = until[k] - below;
  share = total > 0 ? own / total : 0;
  within = own > 0 ? std::clamp((target - below) / own, 0.0, 1 - 0x1p-24) : 0.5;
  return k;
}

double LightTree::sum(uint32_t begin, uint32_t end, LightChannel channel, const SurfacePoint& surface,
                      float* values) const {
  alignas(64) float chunk[kLightChunk];
  alignas(64) int state[kLightChunk];
  double total = 0;
  for (uint32_t first = begin; first < end; first += kLightChunk) {
    const uint32_t n = std::min(kLightChunk, end - first);
    const bool exact = far_light(columns_, first, n, int(channel), surface, chunk, state);
    for (uint32_t i = 0; exact && i < n; ++i) {
      if (state[i] != kNearLight) continue;
      const Source& source = sources_[first + i];
      chunk[i] = float(source.emitter->form_factor_of(source.element, surface) *
                       double(source.radiance[int(channel)]));
    }
    std::fill(chunk + n, chunk + kLightChunk, 0.0f);
    total += double(sum_light(chunk));
    if (values) std::copy(chunk, chunk + n, values + (first - begin));
  }
  return total;
}

void LightTree::sums(uint32_t begin, uint32_t end, LightChannel channel, const SurfaceColumns& surfaces,
                     float* values, double* out) const {
  const ReceiverColumns receivers(surfaces);
  const uint32_t elements = end - begin, count = surfaces.count;
  alignas(64) int state[kBatch];
  for (uint32_t e = 0; e < elements; ++e) {
    float* own = values + e * kBatch;
    if (!far_light_each(columns_, begin + e, int(channel), receivers, own, state)) continue;
    const Source& source = sources_[begin + e];
    for (uint32_t i = 0; i < count; ++i)
      if (state[i] == kNearLight)
        own[i] = float(source.emitter->form_factor_of(source.element, surfaces.point(i)) *
                       double(source.radiance[int(channel)]));
  }
  // The same tree as sum_light(): its other leaves are 0.
  alignas(64) float partial[kLightChunk / 2 * kBatch];
  const float* summands = values;
  uint32_t left = elements;
  for (uint32_t half = kLightChunk / 2; half; half /= 2) {
    if (left <= half) continue;
    for (uint32_t e = 0; e < half; ++e)
      for (uint32_t i = 0; i < count; ++i)
        partial[e * kBatch + i] = e + half < left
                                      ? summands[e * kBatch + i] + summands[(e + half) * kBatch + i]
                                      : summands[e * kBatch + i];
    summands = partial;
    left = half;
  }
  for (uint32_t i = 0; i < count; ++i) out[i] = elements ? double(summands[i]) : 0.0;
}

void LightTree::Source::to_emitter(const float* u, uint32_t count, float* out) const {
  for (uint32_t i = 0; i < count; ++i) out[i] = u_begin + (u_end - u_begin) * u[i];
}

void LightTree::Source::weigh(LightChannel channel, uint32_t count, float* form_factors) const {
  for (uint32_t i = 0; i < count; ++i)
    form_factors[i] = form_factors[i] * (u_end - u_begin) * radiance[int(channel)];
}

void LightTree::evaluate(uint32_t element, LightChannel channel, const SurfacePoint& surface, const float* u,
                         const float* v, uint32_t count, LightPoints& out) const {
  const Source& source = sources_[element];
  alignas(64) float at[kBatch];
  if (count == 0) return;
  source.to_emitter(u, count, at);
  source.emitter->evaluate(surface, at, v, count, out);
  source.weigh(channel, count, out.form_factor);
}

void LightTree::evaluate_each(uint32_t element, LightChannel channel, const SurfaceColumns& surfaces,
                              const float* u, const float* v, LightPoints& out) const {
  const Source& source = sources_[element];
  alignas(64) float at[kBatch];
  source.to_emitter(u, surfaces.count, at);
  source.emitter->evaluate_each(surfaces, at, v, 1, out);
  source.weigh(channel, surfaces.count, out.form_factor);
}

}  // namespace penumbra
