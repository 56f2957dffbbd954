// SPDX-License-Identifier: GPL-3.0-or-later
#include "visibility/long_triangles.h"

#include <algorithm>
#include <unordered_map>

#include "math/transform.h"

namespace penumbra {
namespace {

/// Boxes' half surfaces over triangles' areas: 2 of a triangle in an axis' plane, 4 of a leaf of any
/// direction, above 20 of a wire across the axes. Larger meshes are not looked at.
constexpr double kThin = 10;
constexpr size_t kMostTriangles = 1 << 14;

/// Edges are cut until their boxes are this many times smaller than a triangle's was on average: half as
/// often again is no faster, half as often a tenth slower (tests/benchmarks).
constexpr double kSmaller = 16;

/// Half of a box' surface.
double half_surface(const Vec3d& extent) {
  return extent.x * extent.y + extent.y * extent.z + extent.z * extent.x;
}

class Splitter {
 public:
  Splitter(std::vector<Vec3f>& positions, double most) : positions_(positions), most_(most) {}

  /// Cuts a triangle at the edge with the largest box, and its halves in turn.
  void split(const std::array<uint32_t, 3>& corners, uint32_t whole, TrianglePieces& out) {
    int longest = 0;
    double largest = -1;
    for (int k = 0; k < 3; ++k) {
      const double size = size_of(corners[k], corners[(k + 1) % 3]);
      if (size > largest) largest = size, longest = k;
    }
    if (!(largest > most_)) {
      out.corners.push_back(corners);
      out.whole.push_back(whole);
      return;
    }
    const uint32_t from = corners[longest], to = corners[(longest + 1) % 3],
                   apex = corners[(longest + 2) % 3], middle = middle_of(from, to);
    split({from, middle, apex}, whole, out);
    split({middle, to, apex}, whole, out);
  }

 private:
  double size_of(uint32_t from, uint32_t to) const {
    Box box;
    box.include(Vec3d(positions_[from]));
    box.include(Vec3d(positions_[to]));
    return half_surface(box.extent());
  }
  uint32_t middle_of(uint32_t from, uint32_t to) {
    const auto [low, high] = std::minmax(from, to);
    const auto [found, is_new] =
        middles_.try_emplace(uint64_t(low) << 32 | high, uint32_t(positions_.size()));
    if (is_new) positions_.push_back(Vec3f((Vec3d(positions_[from]) + Vec3d(positions_[to])) * 0.5));
    return found->second;
  }

  std::vector<Vec3f>& positions_;
  double most_;
  std::unordered_map<uint64_t, uint32_t> middles_;  // by an edge's vertices
};

}  // namespace

TrianglePieces split_long_triangles(std::vector<Vec3f>& positions,
                                    const std::vector<std::array<uint32_t, 3>>& triangles) {
  TrianglePieces pieces;
  if (triangles.empty() || triangles.size() > kMostTriangles) return pieces;
  double boxes = 0, areas = 0;
  for (const auto& corners : triangles) {
    const Vec3d a(positions[corners[0]]), b(positions[corners[1]]), c(positions[corners[2]]);
    Box box;
    for (const Vec3d& p : {a, b, c}) box.include(p);
    boxes += half_surface(box.extent());
    areas += length(cross(b - a, c - a)) / 2;
  }
  if (!(boxes > kThin * areas)) return pieces;
  Splitter splitter(positions, boxes / double(triangles.size()) / kSmaller);
  for (uint32_t t = 0; t < triangles.size(); ++t) splitter.split(triangles[t], t, pieces);
  return pieces;
}

}  // namespace penumbra
