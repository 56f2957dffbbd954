// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/strands.h"

#include <cmath>
#include <stdexcept>
#include <string>

namespace penumbra {
namespace {

constexpr size_t kMostKeys = 0xFFFFFFF0u;  // Embree's indices have 32 bits

[[noreturn]] void refuse(const Mesh& mesh, const std::string& reason) {
  throw std::invalid_argument(mesh.name + ": " + reason);
}

void check(const Mesh& mesh, size_t i, const std::string& what) {
  bool finite = is_finite(mesh.positions[i]) && std::isfinite(mesh.radii[i]);
  for (const MeshPose& pose : mesh.motion) finite = finite && is_finite(pose.positions[i]);
  if (!finite) refuse(mesh, "the position or radius of " + what + " is not finite");
  if (mesh.radii[i] < 0) refuse(mesh, "the radius of " + what + " is negative");
}

/// Keys `from` of a mesh, at all times, in this order.
void reorder(Mesh& mesh, const std::vector<uint32_t>& from) {
  const auto picked = [&](const auto& all) {
    std::decay_t<decltype(all)> result;
    result.reserve(from.size());
    for (const uint32_t i : from) result.push_back(all[i]);
    return result;
  };
  mesh.positions = picked(mesh.positions);
  mesh.radii = picked(mesh.radii);
  for (MeshPose& pose : mesh.motion) pose.positions = picked(pose.positions);
}

void check_poses(const Mesh& mesh) {
  for (const MeshPose& pose : mesh.motion)
    if (pose.positions.size() != mesh.positions.size()) refuse(mesh, "the motion has another number of keys");
}

}  // namespace

void make_curves(Mesh& mesh, const std::vector<uint32_t>& counts) {
  check_poses(mesh);
  size_t sum = 0;
  for (const uint32_t count : counts) sum += count;
  if (sum != mesh.positions.size())
    refuse(mesh, "its strands have " + std::to_string(sum) + " keys, but there are " +
                     std::to_string(mesh.positions.size()));
  if (sum + 2 * counts.size() > kMostKeys) refuse(mesh, "its strands have more than 2^32 keys");
  std::vector<uint32_t> from;
  from.reserve(sum + 2 * counts.size());
  uint32_t first = 0;
  for (size_t curve = 0; curve < counts.size(); first += counts[curve++]) {
    const uint32_t count = counts[curve], last = first + count - 1;
    for (uint32_t i = first; i < first + count; ++i) check(mesh, i, "strand " + std::to_string(curve));
    bool kept = false;
    for (uint32_t i = first; count >= 2 && i < last; ++i) {
      if (i == first) from.push_back(first);
      const bool extends = !(mesh.positions[i] == mesh.positions[i + 1]) || !mesh.motion.empty();
      if (extends && (mesh.radii[i] > 0 || mesh.radii[i + 1] > 0)) {
        mesh.segments.push_back(uint32_t(from.size() - 1));
        kept = true;
      }
      from.push_back(i);
      if (i + 1 == last) from.insert(from.end(), {last, last});
    }
    mesh.useless_strands += !kept;
  }
  reorder(mesh, from);
}

void make_points(Mesh& mesh) {
  check_poses(mesh);
  if (mesh.positions.size() > kMostKeys) refuse(mesh, "it has more than 2^32 points");
  std::vector<uint32_t> from;
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    check(mesh, i, "point " + std::to_string(i));
    if (mesh.radii[i] > 0) from.push_back(uint32_t(i));
  }
  mesh.useless_strands = mesh.positions.size() - from.size();
  reorder(mesh, from);
}

}  // namespace penumbra
