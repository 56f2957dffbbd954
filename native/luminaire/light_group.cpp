// SPDX-License-Identifier: GPL-3.0-or-later
#include "luminaire/light_group.h"

#include <algorithm>

namespace penumbra {
namespace {

/// Chooses elements by what they send to one surface point.
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

void LightGroup::evaluate(const SurfacePoint& surface, const float* u, const float* v, uint32_t count,
                          LightPoints& out) const {
  const auto place = [&](const auto& choose) {
    for (uint32_t i = 0; i < count; ++i) {
      double share = 0, within = 0;
      const uint32_t element = choose(double(u[i]), share, within);
      Vec3f to_light;
      float f = 0;
      if (share > 0)
        f = tree_.evaluate(element, channel_, surface, float(within), v[i], to_light) / float(share);
      out.x[i] = to_light.x;
      out.y[i] = to_light.y;
      out.z[i] = to_light.z;
      out.form_factor[i] = f;
    }
  };
  if (tree_.is_far(node_, surface)) {
    place([&](double at, double& share, double& within) {
      return tree_.pick(node_, channel_, at, share, within);
    });
  } else {
    const NearChoice near(tree_, tree_.node(node_), channel_, surface);
    place([&](double at, double& share, double& within) { return near.pick(at, share, within); });
  }
}

}  // namespace penumbra
