// SPDX-License-Identifier: GPL-3.0-or-later
#include "luminaire/light_group.h"

#include <algorithm>
#include <optional>

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

/// Chooses elements by what they send to one surface point. A thread has one at a time.
class NearChoice {
 public:
  NearChoice(const LightTree& tree, const LightNode& node, LightChannel channel, const SurfacePoint& surface)
      : begin_(node.begin), values_(own_values()), until_(own_sums()) {
    const uint32_t size = node.end - node.begin;
    values_.resize(size);
    until_.resize(size);
    tree.sum(node.begin, node.end, channel, surface, values_.data());
    for (uint32_t i = 0; i < size; ++i) until_[i] = total_ += double(values_[i]);
  }

  /// As LightTree::pick(); nothing where share is 0.
  uint32_t pick(double at, double& share, double& within) const {
    const double target = at * total_;
    const auto k = size_t(std::upper_bound(until_.begin(), until_.end() - 1, target) - until_.begin());
    const auto own = double(values_[k]);
    share = own > 0 ? own / total_ : 0;
    within = own > 0 ? std::clamp((target - (until_[k] - own)) / own, 0.0, 1 - 0x1p-24) : 0.5;
    return begin_ + uint32_t(k);
  }

 private:
  // A thread's own memory, which it need not ask for again.
  static std::vector<float>& own_values() {
    thread_local std::vector<float> values;
    return values;
  }
  static std::vector<double>& own_sums() {
    thread_local std::vector<double> sums;
    return sums;
  }

  uint32_t begin_;
  std::vector<float>& values_;
  std::vector<double>& until_;  // sum of values up to each element, itself included
  double total_ = 0;
};

}  // namespace

double LightGroup::form_factor(const SurfacePoint& surface) const {
  const LightNode& node = tree_.node(node_);
  return tree_.sum(node.begin, node.end, channel_, surface, nullptr);
}

void LightGroup::form_factors(const SurfaceColumns& surfaces, double* out) const {
  SurfacePoint anchor;
  LightField field;
  double exact = 0, correction = 0;  // at the anchor; over the field's, 0 while that is not known
  for (uint32_t i = 0; i < surfaces.count; ++i) {
    const SurfacePoint surface = surfaces.point(i);
    const Vec3d way = surface.position - anchor.position;
    const double distance = length(way);
    if (i > 0 && tree_.is_smooth(node_, anchor, distance) && tree_.is_smooth(node_, surface, distance)) {
      if (correction == 0) {
        field = tree_.field(node_, channel_, anchor.position);
        const double linear = dot(anchor.normal, field.value);
        correction = linear > 0 ? exact / linear : 1;
      }
      const Vec3d light =
          field.value + field.gradient[0] * way.x + field.gradient[1] * way.y + field.gradient[2] * way.z;
      out[i] = std::max(dot(surface.normal, light) * correction, 0.0);
      continue;
    }
    out[i] = exact = form_factor(surface);
    anchor = surface;
    correction = 0;
  }
}

template <typename Choice>
void LightGroup::place(const Choice& choice, const SurfacePoint& surface, float u, float v, LightPoints& out,
                       uint32_t i) const {
  double share = 0, within = 0;
  const uint32_t element = choice.pick(double(u), share, within);
  Vec3f to_light;
  float f = 0;
  if (share > 0) f = tree_.evaluate(element, channel_, surface, float(within), v, to_light) / float(share);
  out.x[i] = to_light.x;
  out.y[i] = to_light.y;
  out.z[i] = to_light.z;
  out.form_factor[i] = f;
}

void LightGroup::evaluate(const SurfacePoint& surface, const float* u, const float* v, uint32_t count,
                          LightPoints& out) const {
  const auto place_all = [&](const auto& choice) {
    for (uint32_t i = 0; i < count; ++i) place(choice, surface, u[i], v[i], out, i);
  };
  if (tree_.is_far(node_, surface))
    place_all(FarChoice{tree_, node_, channel_});
  else
    place_all(NearChoice(tree_, tree_.node(node_), channel_, surface));
}

void LightGroup::evaluate_each(const SurfaceColumns& surfaces, const float* u, const float* v,
                               LightPoints& out) const {
  std::optional<NearChoice> near;
  SurfacePoint anchor;  // the choice's
  for (uint32_t i = 0; i < surfaces.count; ++i) {
    const SurfacePoint surface = surfaces.point(i);
    if (tree_.is_far(node_, surface)) {
      place(FarChoice{tree_, node_, channel_}, surface, u[i], v[i], out, i);
      continue;
    }
    const double distance = length(surface.position - anchor.position);
    if (!near || !tree_.is_smooth(node_, anchor, distance) || !tree_.is_smooth(node_, surface, distance)) {
      near.emplace(tree_, tree_.node(node_), channel_, surface);
      anchor = surface;
    }
    place(*near, surface, u[i], v[i], out, i);
  }
}

}  // namespace penumbra
