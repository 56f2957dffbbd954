// SPDX-License-Identifier: GPL-3.0-or-later
#include "visibility/outlines.h"

#include <algorithm>
#include <numeric>
#include <unordered_map>

namespace penumbra {
namespace {

/// Flat facets, or normals at a shared corner, that differ by less than this are shaded as one.
constexpr double kSmoothStep = 1e-3;

struct MeshEdge {
  static constexpr uint32_t kNone = ~0u;

  uint32_t from, to;                 // vertices
  uint32_t triangle, other = kNone;  // none: not exactly two share it
};

/// All edges of a mesh, found by sorting the triangles' sides by their vertices.
std::vector<MeshEdge> edges_of(const PlacedMesh& mesh) {
  struct Side {
    uint32_t to, triangle;
  };
  const auto for_each_side = [&mesh](auto function) {
    for (uint32_t t = 0; t < mesh.triangles.size(); ++t)
      for (int k = 0; k < 3; ++k) {
        const auto [low, high] = std::minmax(mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3]);
        function(low, Side{high, t});
      }
  };
  std::vector<uint32_t> end(mesh.positions.size() + 1, 0);  // of the sides that begin at each vertex
  for_each_side([&end](uint32_t low, Side) { ++end[low + 1]; });
  std::partial_sum(end.begin(), end.end(), end.begin());
  std::vector<Side> sides(end.back());
  for_each_side([&](uint32_t low, Side side) { sides[end[low]++] = side; });
  std::vector<MeshEdge> edges;
  edges.reserve(sides.size() / 2 + 1);
  for (uint32_t vertex = 0, i = 0; vertex + 1 < end.size(); ++vertex) {
    const uint32_t last = end[vertex];
    std::sort(sides.begin() + i, sides.begin() + last, [](const Side& a, const Side& b) {
      return a.to != b.to ? a.to < b.to : a.triangle < b.triangle;
    });
    while (i < last) {
      uint32_t next = i + 1;
      while (next < last && sides[next].to == sides[i].to) ++next;
      edges.push_back(
          {vertex, sides[i].to, sides[i].triangle, next - i == 2 ? sides[i + 1].triangle : MeshEdge::kNone});
      i = next;
    }
  }
  return edges;
}

/// Do the two triangles of an edge have the same normals at its ends?
bool shaded_as_one(const PlacedMesh& mesh, const MeshEdge& edge) {
  if (mesh.corner_normals.empty() || mesh.normals_of_vertices) return true;
  const auto normal = [&mesh](uint32_t triangle, uint32_t vertex) {
    const auto& corners = mesh.triangles[triangle];
    const auto corner = uint32_t(std::find(corners.begin(), corners.end(), vertex) - corners.begin());
    return normalize(mesh.corner_normal(triangle, corner, 0.5));
  };
  for (const uint32_t vertex : {edge.from, edge.to}) {
    const Vec3d difference = normal(edge.triangle, vertex) - normal(edge.other, vertex);
    if (!(dot(difference, difference) <= kSmoothStep * kSmoothStep)) return false;
  }
  return true;
}

}  // namespace

std::vector<OutlinePiece> find_outlines(const Geometry& geometry, const Eye& eye) {
  std::vector<OutlinePiece> outlines;
  std::vector<Facet> facets;
  std::unordered_map<const PlacedMesh*, std::vector<MeshEdge>> edges;  // of meshes so far
  for (uint32_t i = 0; i < geometry.instances(); ++i) {
    const PlacedMesh& mesh = geometry.mesh_of(i);
    const uint32_t triangles = geometry.triangles_of(i);
    if (triangles == 0) continue;
    const auto [of_mesh, is_new] = edges.try_emplace(&mesh);
    if (is_new) of_mesh->second = edges_of(mesh);
    const Affine* render_from_mesh = geometry.placing_of(i);
    const Eye here = render_from_mesh ? eye.seen_from(*render_from_mesh) : eye;
    facets.clear();
    for (uint32_t t = 0; t < triangles; ++t) {
      Hit hit;
      hit.instance = i, hit.triangle = t;
      facets.push_back(geometry.facet_of(hit));
    }
    const auto is_front = [&here](const Facet& f) {
      return dot(f.normal, here.parallel ? here.place : here.place - f.corner) > 0;
    };
    for (const MeshEdge& edge : of_mesh->second) {
      if (edge.other != MeshEdge::kNone) {
        const Facet &a = facets[edge.triangle], &b = facets[edge.other];
        if (is_front(a) == is_front(b) && same_surface(a, b) && step_between(a, b) <= kSmoothStep &&
            shaded_as_one(mesh, edge))
          continue;
      }
      const auto place = [&](uint32_t vertex) {
        const Vec3d p = mesh.position(vertex, 0.5);
        return render_from_mesh ? render_from_mesh->point(p) : p;
      };
      outlines.push_back({place(edge.from), place(edge.to)});
    }
  }
  return outlines;
}

}  // namespace penumbra
