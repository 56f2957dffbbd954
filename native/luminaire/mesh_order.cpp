// SPDX-License-Identifier: GPL-3.0-or-later
#include "luminaire/mesh_order.h"

#include <algorithm>
#include <numeric>

namespace penumbra {
namespace {

/// The lowest 21 bits of x with two zeros after each.
uint64_t spread_bits(uint64_t x) {
  x = (x | x << 32) & 0x001F00000000FFFFu;
  x = (x | x << 16) & 0x001F0000FF0000FFu;
  x = (x | x << 8) & 0x100F00F00F00F00Fu;
  x = (x | x << 4) & 0x10C30C30C30C30C3u;
  return (x | x << 2) & 0x1249249249249249u;
}

}  // namespace

bool is_closed(const std::vector<Corners>& triangles) {
  std::vector<std::pair<uint32_t, uint32_t>> edges, reversed;
  for (const Corners& t : triangles)
    for (int i = 0; i < 3; ++i) {
      edges.emplace_back(t[i], t[(i + 1) % 3]);
      reversed.emplace_back(t[(i + 1) % 3], t[i]);
    }
  std::sort(edges.begin(), edges.end());
  std::sort(reversed.begin(), reversed.end());
  const bool once = std::adjacent_find(edges.begin(), edges.end()) == edges.end();
  return once && edges == reversed;
}

std::vector<Corners> outward(std::vector<Corners> triangles, const std::vector<Vec3d>& positions) {
  std::vector<uint32_t> parent(positions.size());
  std::iota(parent.begin(), parent.end(), 0u);
  const auto root = [&parent](uint32_t v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (const Corners& t : triangles) {
    parent[root(t[1])] = root(t[0]);
    parent[root(t[2])] = root(t[0]);
  }
  std::vector<double> volumes(positions.size(), 0.0);
  for (const Corners& t : triangles) {
    const uint32_t part = root(t[0]);
    const Vec3d& origin = positions[part];
    volumes[part] += dot(positions[t[0]] - origin, cross(positions[t[1]] - origin, positions[t[2]] - origin));
  }
  for (Corners& t : triangles)
    if (volumes[root(t[0])] < 0) std::swap(t[1], t[2]);
  return triangles;
}

std::vector<size_t> curve_order(const std::vector<Corners>& triangles, const std::vector<Vec3d>& positions,
                                const Box& bounds) {
  const double size = std::max(max_abs(bounds.extent()), 1e-300);
  std::vector<std::pair<uint64_t, size_t>> order;
  for (size_t i = 0; i < triangles.size(); ++i) {
    const Vec3d centre =
        (positions[triangles[i][0]] + positions[triangles[i][1]] + positions[triangles[i][2]]) / 3.0;
    uint64_t code = 0;
    for (int axis = 0; axis < 3; ++axis) {
      // The sum of corners near the largest number is beyond it: its place may be nowhere in the box.
      const double place = (centre[axis] - bounds.low[axis]) / size;
      code |= spread_bits(uint64_t((place > 0 ? std::min(place, 1.0) : 0.0) * 0x1FFFFF)) << axis;
    }
    order.emplace_back(code, i);
  }
  std::sort(order.begin(), order.end());
  std::vector<size_t> result;
  for (const auto& [code, i] : order) result.push_back(i);
  return result;
}

}  // namespace penumbra
