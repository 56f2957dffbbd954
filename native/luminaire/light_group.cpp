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

}  // namespace

LightGroup::LightGroup(const LightTree& tree, uint32_t node, LightChannel channel, double smallest_side)
    : tree_(tree), node_(node), channel_(channel), cells_(tree, node, channel, smallest_side) {}

double LightGroup::form_factor(const SurfacePoint& surface) const {
  return cells_.form_factor(surface);
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
  if (tree_.node(node_).is_below(surface)) {
    std::fill(out.x, out.x + count, 0.0f);
    std::fill(out.y, out.y + count, 0.0f);
    std::fill(out.z, out.z + count, 0.0f);
    std::fill(out.form_factor, out.form_factor + count, 0.0f);
  } else if (tree_.is_far(node_, surface)) {
    place_all(FarChoice{tree_, node_, channel_});
  } else if (const LightChoice* shared = cells_.choice(surface)) {
    place_all(*shared);
  } else {
    thread_local LightChoice own;  // keeps its memory
    own.fill(tree_, node_, channel_, surface);
    place_all(own);
  }
}

}  // namespace penumbra
