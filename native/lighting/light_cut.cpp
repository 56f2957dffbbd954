// SPDX-License-Identifier: GPL-3.0-or-later
#include "lighting/light_cut.h"

#include <algorithm>
#include <cmath>

#include "luminaire/light_cells.h"

namespace penumbra {
namespace {

/// Luminaires in a cut: memory and the first look grow with it, the share of what needs no more rays, too.
constexpr size_t kMost = 40;

/// Groups of less light than so many tolerances are not split.
constexpr double kGroupSize = 2.0;

struct Candidate {
  double size;  // upper bound of its light at the probe that gets most, white
  uint32_t node;

  /// The node's number decides where bounds are infinite, or equal.
  bool operator<(const Candidate& other) const {
    return size != other.size ? size < other.size : node > other.node;
  }
};

double largest_light(const LightNode& node, std::span<const LitPoint> probes, double display_scale) {
  double largest = 0;
  for (const LitPoint& probe : probes)
    largest = std::max(largest, max_component(probe.throughput) * max_component(node.bound(probe.surface)));
  return largest * display_scale;
}

}  // namespace

std::vector<Luminaire> cut_luminaires(const LightTree& tree, std::span<const LitPoint> probes,
                                      double tolerance, double display_scale) {
  std::vector<Candidate> heap, leaves;
  size_t count = 0;
  const auto add = [&](uint32_t node) {
    const Candidate candidate{largest_light(tree.node(node), probes, display_scale), node};
    count += tree.count(node);
    if (tree.node(node).is_leaf()) {
      leaves.push_back(candidate);
    } else {
      heap.push_back(candidate);
      std::push_heap(heap.begin(), heap.end());
    }
  };
  for (uint32_t root : tree.roots()) add(root);
  while (!heap.empty() && count < kMost && heap.front().size > kGroupSize * tolerance) {
    std::pop_heap(heap.begin(), heap.end());
    const uint32_t node = heap.back().node;
    heap.pop_back();
    count -= tree.count(node);
    add(node + 1);
    add(tree.node(node).right);
  }
  leaves.insert(leaves.end(), heap.begin(), heap.end());
  std::sort(leaves.begin(), leaves.end());
  std::vector<Luminaire> luminaires;
  std::vector<Vec3d> places;
  for (const LitPoint& probe : probes) places.push_back(probe.surface.position);
  const double side = shared_cube_side(places);
  for (const Candidate& candidate : leaves) tree.append(candidate.node, side, luminaires);
  luminaires.insert(luminaires.end(), tree.rest().begin(), tree.rest().end());
  return luminaires;
}

}  // namespace penumbra
