// SPDX-License-Identifier: GPL-3.0-or-later
#include "luminaire/light_group.h"

#include <algorithm>

namespace penumbra {
namespace {

/// Chooses elements by their power.
struct FarChoice {
  const LightTree& tree;
  uint32_t node;
  LightChannel channel;

  uint32_t pick(double at, double& share, double& within) const {
    return tree.pick(node, channel, at, share, within);
  }
};

void clear(LightPoints& points, uint32_t count) {
  std::fill(points.x, points.x + count, 0.0f);
  std::fill(points.y, points.y + count, 0.0f);
  std::fill(points.z, points.z + count, 0.0f);
  std::fill(points.form_factor, points.form_factor + count, 0.0f);
}

/// What point number `number` of those asked for became: a place in an element.
struct Picked {
  uint32_t number, element;
  float share, within;
};

/// False: nothing.
template <typename Choice>
bool pick(const Choice& choice, float u, uint32_t number, Picked& picked) {
  double share = 0, within = 0;
  const uint32_t element = choice.pick(double(u), share, within);
  picked = {number, element, float(share), float(within)};
  return share > 0;
}

/// Puts points of one element where they belong.
void place(std::span<const Picked> picked, const LightPoints& points, LightPoints& out) {
  for (size_t i = 0; i < picked.size(); ++i) {
    const uint32_t at = picked[i].number;
    out.x[at] = points.x[i];
    out.y[at] = points.y[i];
    out.z[at] = points.z[i];
    out.form_factor[at] = points.form_factor[i] / picked[i].share;
  }
}

}  // namespace

LightGroup::LightGroup(const LightTree& tree, uint32_t node, LightChannel channel, double smallest_side)
    : tree_(tree), node_(node), channel_(channel), cells_(tree, node, channel, smallest_side) {}

double LightGroup::form_factor(const SurfacePoint& surface) const {
  return cells_.form_factor(surface);
}

void LightGroup::form_factors(const SurfaceColumns& surfaces, double* out) const {
  cells_.form_factors(surfaces, out);
}

template <typename Function>
void LightGroup::choose(const SurfacePoint& surface, const float* values, Function function) const {
  const LightNode& n = tree_.node(node_);
  if (n.is_below(surface)) return;
  if (tree_.is_far(node_, surface)) return function(FarChoice{tree_, node_, channel_});
  if (const LightChoice* shared = cells_.choice(surface)) return function(*shared);
  thread_local LightChoice own;  // keeps its memory
  if (values)
    own.fill(n.begin, n.end - n.begin, values, kBatch);
  else
    own.fill(tree_, node_, channel_, surface);
  function(own);
}

template <typename Picked, typename Function>
void LightGroup::for_elements(std::span<const Picked> picked, Function function) const {
  const uint32_t begin = tree_.node(node_).begin;
  if (!cells_.is_small()) {  // hardly two points have the same
    for (const Picked& one : picked) function(std::span(&one, 1));
    return;
  }
  // Sorted by counting.
  uint32_t end_of[LightCells::kWorthACube + 1] = {};
  for (const Picked& one : picked) ++end_of[one.element - begin + 1];
  for (uint32_t e = 1; e <= LightCells::kWorthACube; ++e) end_of[e] += end_of[e - 1];
  Picked sorted[kBatch];
  for (const Picked& one : picked) sorted[end_of[one.element - begin]++] = one;
  for (size_t first = 0; first < picked.size(); first = end_of[sorted[first].element - begin])
    function(std::span(sorted + first, sorted + end_of[sorted[first].element - begin]));
}

void LightGroup::evaluate(const SurfacePoint& surface, const float* u, const float* v, uint32_t count,
                          LightPoints& out) const {
  clear(out, count);
  Picked picked[kBatch];
  uint32_t chosen = 0;
  choose(surface, nullptr, [&](const auto& choice) {
    for (uint32_t i = 0; i < count; ++i)
      if (pick(choice, u[i], i, picked[chosen])) ++chosen;
  });
  alignas(64) float own_u[kBatch], own_v[kBatch];
  LightPoints points;
  for_elements(std::span<const Picked>(picked, chosen), [&](std::span<const Picked> own) {
    for (size_t i = 0; i < own.size(); ++i) own_u[i] = own[i].within, own_v[i] = v[own[i].number];
    tree_.evaluate(own.front().element, channel_, surface, own_u, own_v, uint32_t(own.size()), points);
    place(own, points, out);
  });
}

void LightGroup::evaluate_each(const SurfaceColumns& surfaces, const float* u, const float* v,
                               uint32_t points, LightPoints& out) const {
  const LightNode& n = tree_.node(node_);
  const uint32_t count = surfaces.count, all = points * count;
  clear(out, all);
  alignas(64) float values[LightCells::kWorthACube * kBatch];
  alignas(64) double unused[kBatch];
  if (cells_.is_small()) tree_.sums(n.begin, n.end, channel_, surfaces, values, unused);
  Picked picked[kBatch];
  uint32_t chosen = 0;
  for (uint32_t i = 0; i < count; ++i)
    choose(surfaces.point(i), cells_.is_small() ? values + i : nullptr, [&](const auto& choice) {
      for (uint32_t at = i; at < all; at += count)
        if (pick(choice, u[at], at, picked[chosen])) ++chosen;
    });
  SurfaceColumns own_surfaces;
  alignas(64) float own_u[kBatch], own_v[kBatch];
  LightPoints own_points;
  for_elements(std::span<const Picked>(picked, chosen), [&](std::span<const Picked> own) {
    if (own.size() == 1) {
      const SurfacePoint surface = surfaces.point(own.front().number % count);
      tree_.evaluate(own.front().element, channel_, surface, &own.front().within, &v[own.front().number], 1,
                     own_points);
      return place(own, own_points, out);
    }
    own_surfaces.count = 0;
    for (size_t i = 0; i < own.size(); ++i) {
      own_u[i] = own[i].within, own_v[i] = v[own[i].number];
      own_surfaces.add(surfaces, own[i].number % count);
    }
    tree_.evaluate_each(own.front().element, channel_, own_surfaces, own_u, own_v, own_points);
    place(own, own_points, out);
  });
}

}  // namespace penumbra
