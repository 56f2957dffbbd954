// SPDX-License-Identifier: GPL-3.0-or-later
#include "visibility/occluder_tree.h"

#include <algorithm>
#include <cmath>

#include "math/simd.h"
#include "visibility/placed_mesh.h"
#include "visibility/shadow_rays.h"

namespace penumbra {
namespace {

constexpr uint32_t kWide = 8;
constexpr unsigned kDepth = 64;

/// Up to kWide triangles: x, y, z of the first, second and third corners. Those that are not there have no
/// area.
struct alignas(64) Leaf {
  float corner[9][kWide];
};
/// Boxes of up to kWide children: low x, y, z, high x, y, z. Those that are not there are empty.
struct alignas(64) Node {
  float bounds[6][kWide];
  uintptr_t child[kWide];  // a Node, or a Leaf with kLeaf
};
constexpr uintptr_t kLeaf = 1;

/// Points p of a shaft from a point to a parallelogram: n p >= distance for each plane, within a box.
struct Shaft {
  static constexpr uint32_t kPlanes = 5;  // four sides and the horizon

  explicit Shaft(const LuminaireView& view);

  float low[3], high[3];
  float x[kPlanes], y[kPlanes], z[kPlanes], distance[kPlanes];
  uint32_t far_x[kPlanes], far_y[kPlanes],
      far_z[kPlanes];  // where in Node::bounds a box's farthest corner is
};

Shaft::Shaft(const LuminaireView& view) {
  const Vec3f& o = view.origin;
  const Vec3f corners[4] = {view.corner, view.corner + view.edge_u, view.corner + view.edge_u + view.edge_v,
                            view.corner + view.edge_v};
  const Vec3f middle = (corners[0] + corners[2]) * 0.5f;
  for (uint32_t i = 0; i < kPlanes; ++i) {
    Vec3f n = i < 4 ? cross(corners[i], corners[(i + 1) % 4]) : view.normal;
    if (i < 4 && dot(n, middle) < 0) n = -n;
    x[i] = n.x, y[i] = n.y, z[i] = n.z;
    // Wider by what rounding may move a corner of the box, a few units in the last place of the scene's size.
    distance[i] = dot(n, o) - 0x1p-19f * (std::abs(n.x) + std::abs(n.y) + std::abs(n.z));
    far_x[i] = n.x > 0 ? 3 * kWide : 0, far_y[i] = n.y > 0 ? 4 * kWide : kWide,
    far_z[i] = n.z > 0 ? 5 * kWide : 2 * kWide;
  }
  low[0] = high[0] = o.x, low[1] = high[1] = o.y, low[2] = high[2] = o.z;
  for (const Vec3f& c : corners) {
    const float p[3] = {o.x + c.x, o.y + c.y, o.z + c.z};
    for (int k = 0; k < 3; ++k) low[k] = std::min(low[k], p[k]), high[k] = std::max(high[k], p[k]);
  }
}

/// (a + b) x (b - a) = 2 a x b: exactly the opposite for the same edge of the neighbour, so that no ray
/// passes between them (no contraction).
inline Vec3f edge_normal(const Vec3f& a, const Vec3f& b) {
  return cross(a + b, b - a);
}

/// Triangles of a leaf as functions on the parallelogram.
struct LeafOccluders {
  alignas(64) float constant[4][kWide], slope[4][kWide], speed[4][kWide];
  alignas(64) float first_tau[kWide], end_tau[kWide];
  alignas(64) int hides[kWide];  // maybe
};

/// Places on the parallelogram by a direction's parts along three vectors.
struct Projection {
  Vec3f depth;  // of a direction d: d depth = 1 in the parallelogram's plane
  Vec3f tau;    // tau = (d tau) / (d depth) - tau_of_corner
  float tau_of_corner;

  explicit Projection(const LuminaireView& view) {
    const Vec3f normal = cross(view.edge_u, view.edge_v);
    const float square = dot(normal, normal);
    depth = normal * (1 / dot(normal, view.corner));
    tau = (cross(normal, view.edge_u) - cross(view.edge_v, normal) * view.skew) * (1 / square);
    tau_of_corner = dot(view.corner, tau);
  }
};

inline void find_functions(const Leaf& leaf, const LuminaireView& view, const Projection& project,
                           LeafOccluders& out) {
  const Vec3f o = view.origin, corner = view.corner, u = view.edge_u, v = view.edge_v;
  const Vec3f depth = project.depth, tau = project.tau;
  const float skew = view.skew;
  const float tau_of_corner = project.tau_of_corner;
  for (uint32_t i = 0; i < kWide; ++i) {
    const Vec3f a{leaf.corner[0][i] - o.x, leaf.corner[1][i] - o.y, leaf.corner[2][i] - o.z};
    const Vec3f b{leaf.corner[3][i] - o.x, leaf.corner[4][i] - o.y, leaf.corner[5][i] - o.z};
    const Vec3f c{leaf.corner[6][i] - o.x, leaf.corner[7][i] - o.y, leaf.corner[8][i] - o.z};
    const Vec3f ab = edge_normal(a, b), bc = edge_normal(b, c), ca = edge_normal(c, a);
    const float volume = dot(a, bc);
    const float side = volume < 0 ? -1.0f : 1.0f;
    const float k0 = side * dot(ab, corner), k1 = side * dot(bc, corner), k2 = side * dot(ca, corner);
    const float u0 = side * dot(ab, u), u1 = side * dot(bc, u), u2 = side * dot(ca, u);
    const float v0 = side * dot(ab, v), v1 = side * dot(bc, v), v2 = side * dot(ca, v);
    // A ray meets the triangle's plane at volume / (the sum of the three) of its way.
    const float k3 = k0 + k1 + k2 - side * volume * (1.0f / kShadowReach), u3 = u0 + u1 + u2,
                v3 = v0 + v1 + v2;
    const auto reaches = [](float k, float along_u, float along_v) {
      return k + (along_u > 0 ? along_u : 0.0f) + (along_v > 0 ? along_v : 0.0f) >= 0;
    };
    const bool reaches_0 = reaches(k0, u0, v0), reaches_1 = reaches(k1, u1, v1),
               reaches_2 = reaches(k2, u2, v2), reaches_end = reaches(k3, u3, v3);
    out.hides[i] = (side * volume > 0) & reaches_0 & reaches_1 & reaches_2 & reaches_end;
    out.constant[0][i] = k0, out.constant[1][i] = k1, out.constant[2][i] = k2, out.constant[3][i] = k3;
    out.slope[0][i] = v0, out.slope[1][i] = v1, out.slope[2][i] = v2, out.slope[3][i] = v3;
    out.speed[0][i] = u0 + skew * v0, out.speed[1][i] = u1 + skew * v1, out.speed[2][i] = u2 + skew * v2,
    out.speed[3][i] = u3 + skew * v3;
    const float da = dot(a, depth), db = dot(b, depth), dc = dot(c, depth);
    const float ta = dot(a, tau) / da - tau_of_corner, tb = dot(b, tau) / db - tau_of_corner,
                tc = dot(c, tau) / dc - tau_of_corner;
    // A corner behind the point, or close to it, is not where it seems.
    const bool ahead = (da > 1e-4f) & (db > 1e-4f) & (dc > 1e-4f);
    float first = ta < tb ? ta : tb, end = ta > tb ? ta : tb;
    first = first < tc ? first : tc, end = end > tc ? end : tc;
    out.first_tau[i] = ahead ? first : -4.0f, out.end_tau[i] = ahead ? end : 4.0f;
  }
}

/// Of those that may hide something, as many as there is room for in kWide; returns how many.
inline uint32_t append(const LeafOccluders& found, Occluder* out) {
  constexpr float kLeast = 1e-30f, kFar = 1e30f;
  alignas(64) float inverse[4][kWide], upper[4][kWide];
  for (int f = 0; f < 4; ++f)
    for (uint32_t i = 0; i < kWide; ++i) {
      const float speed = found.speed[f][i], size = std::abs(speed);
      const float positive = 1.0f / (size > kLeast ? size : kLeast);
      inverse[f][i] = speed < 0 ? positive : -positive;
      upper[f][i] = speed < 0 ? 0.0f : kFar;
    }
  uint32_t count = 0;
  for (uint32_t i = 0; i < kWide; ++i) {
    if (!found.hides[i]) continue;
    Occluder& o = out[count++];
    for (int f = 0; f < 4; ++f) {
      o.constant[f] = found.constant[f][i], o.slope[f] = found.slope[f][i], o.inverse[f] = inverse[f][i];
      o.upper[f] = upper[f][i], o.lower[f] = upper[f][i] - kFar;
    }
    o.first_tau = found.first_tau[i], o.end_tau = found.end_tau[i];
  }
  return count;
}

PENUMBRA_VECTORIZED
bool find_in(uintptr_t root, const LuminaireView& from, const Shaft& within, uint32_t most,
             std::vector<Occluder>& out) {
  const LuminaireView view = from;
  const Shaft shaft = within;
  const Projection projection(view);
  uintptr_t stack[kDepth * kWide + 1];
  uint32_t top = 0, count = 0;
  if (root) stack[top++] = root;
  LeafOccluders found;
  while (top) {
    const uintptr_t at = stack[--top];
    if (at & kLeaf) {
      if (count > most) return false;
      if (out.size() < count + kWide) out.resize(2 * count + 8 * kWide);
      find_functions(*reinterpret_cast<const Leaf*>(at & ~kLeaf), view, projection, found);
      count += append(found, out.data() + count);
      continue;
    }
    const Node& node = *reinterpret_cast<const Node*>(at);
    const float(*b)[kWide] = node.bounds;
    alignas(64) int inside[kWide];
    for (uint32_t i = 0; i < kWide; ++i)
      inside[i] = (b[0][i] <= shaft.high[0]) & (b[3][i] >= shaft.low[0]) & (b[1][i] <= shaft.high[1]) &
                  (b[4][i] >= shaft.low[1]) & (b[2][i] <= shaft.high[2]) & (b[5][i] >= shaft.low[2]);
    for (uint32_t p = 0; p < Shaft::kPlanes; ++p) {
      const float *x = b[0] + shaft.far_x[p], *y = b[0] + shaft.far_y[p], *z = b[0] + shaft.far_z[p];
      const float nx = shaft.x[p], ny = shaft.y[p], nz = shaft.z[p], distance = shaft.distance[p];
      for (uint32_t i = 0; i < kWide; ++i) inside[i] &= int(x[i] * nx + y[i] * ny + z[i] * nz >= distance);
    }
    for (uint32_t i = 0; i < kWide; ++i) {
      stack[top] = node.child[i];
      top += uint32_t(inside[i]);
    }
  }
  out.resize(count);
  return count <= most;
}

}  // namespace

std::optional<LuminaireView> LuminaireView::from(const SurfacePoint& surface, const Parallelogram& luminaire,
                                                 float direction) {
  constexpr float kLeastSkew = 0.2f, kMostSkew = 0.7f;
  // Cubes of these stay within single precision.
  constexpr double kMost = 1e6, kLeast = 1e-6;
  const Vec3d from = luminaire.corner - surface.position;
  const double u = max_abs(luminaire.edge_u), v = max_abs(luminaire.edge_v);
  if (!(max_abs(from) < kMost && u < kMost && v < kMost && u > kLeast && v > kLeast)) return std::nullopt;
  bool above = false, below = false;
  for (const Vec3d& corner :
       {from, from + luminaire.edge_u, from + luminaire.edge_v, from + luminaire.edge_u + luminaire.edge_v})
    (dot(corner, surface.geometric_normal) >= 0 ? above : below) = true;
  // What a flat surface has below its horizon does not light it.
  const bool flat = surface.normal == surface.geometric_normal;
  if (above && below && !flat) return std::nullopt;
  const ShadowSide side = shadow_side(surface, above ? 1 : -1);
  if (!is_finite(side.origin)) return std::nullopt;
  return LuminaireView{side.origin,
                       Vec3f(luminaire.corner - Vec3d(side.origin)),
                       Vec3f(luminaire.edge_u),
                       Vec3f(luminaire.edge_v),
                       Vec3f(surface.normal),
                       kLeastSkew + (kMostSkew - kLeastSkew) * direction};
}

OccluderTree::OccluderTree(embree::CountedDevice& device, const std::vector<const PlacedMesh*>& meshes) {
  std::vector<RTCBuildPrimitive> primitives;
  for (unsigned number = 0; number < meshes.size(); ++number) {
    const PlacedMesh& mesh = *meshes[number];
    for (unsigned i = 0; i < mesh.triangles.size(); ++i) {
      const auto& t = mesh.triangles[i];
      const Vec3f &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
      primitives.push_back({std::min({a.x, b.x, c.x}), std::min({a.y, b.y, c.y}), std::min({a.z, b.z, c.z}),
                            number, std::max({a.x, b.x, c.x}), std::max({a.y, b.y, c.y}),
                            std::max({a.z, b.z, c.z}), i});
    }
  }
  bvh_.reset(rtcNewBVH(device.device.get()));
  RTCBuildArguments build = rtcDefaultBuildArguments();
  build.maxBranchingFactor = kWide;
  build.maxDepth = kDepth;
  build.sahBlockSize = kWide;
  build.minLeafSize = kWide / 2;
  build.maxLeafSize = kWide;
  build.bvh = bvh_.get();
  build.primitives = primitives.data();
  build.primitiveCount = build.primitiveArrayCapacity = primitives.size();
  build.createNode = [](RTCThreadLocalAllocator allocator, unsigned, void*) -> void* {
    auto* node = static_cast<Node*>(rtcThreadLocalAlloc(allocator, sizeof(Node), alignof(Node)));
    for (uint32_t i = 0; i < kWide; ++i) {
      for (uint32_t k = 0; k < 6; ++k) node->bounds[k][i] = k < 3 ? INFINITY : -INFINITY;
      node->child[i] = 0;
    }
    return node;
  };
  build.setNodeChildren = [](void* node, void** children, unsigned count, void*) {
    for (unsigned i = 0; i < count; ++i) static_cast<Node*>(node)->child[i] = uintptr_t(children[i]);
  };
  build.setNodeBounds = [](void* at, const RTCBounds** boxes, unsigned count, void*) {
    auto& bounds = static_cast<Node*>(at)->bounds;
    for (unsigned i = 0; i < count; ++i) {
      const RTCBounds& box = *boxes[i];
      bounds[0][i] = box.lower_x, bounds[1][i] = box.lower_y, bounds[2][i] = box.lower_z;
      bounds[3][i] = box.upper_x, bounds[4][i] = box.upper_y, bounds[5][i] = box.upper_z;
    }
  };
  build.createLeaf = [](RTCThreadLocalAllocator allocator, const RTCBuildPrimitive* primitive, size_t count,
                        void* user) -> void* {
    auto* leaf = static_cast<Leaf*>(rtcThreadLocalAlloc(allocator, sizeof(Leaf), alignof(Leaf)));
    for (uint32_t i = 0; i < kWide; ++i) {
      const RTCBuildPrimitive& p = primitive[std::min<size_t>(i, count - 1)];
      const PlacedMesh& mesh = *(*static_cast<const std::vector<const PlacedMesh*>*>(user))[p.geomID];
      for (uint32_t k = 0; k < 3; ++k) {
        const Vec3f& corner = mesh.positions[mesh.triangles[p.primID][i < count ? k : 0]];
        leaf->corner[3 * k][i] = corner.x, leaf->corner[3 * k + 1][i] = corner.y,
                         leaf->corner[3 * k + 2][i] = corner.z;
      }
    }
    return reinterpret_cast<void*>(uintptr_t(leaf) | kLeaf);
  };
  build.userPtr = const_cast<std::vector<const PlacedMesh*>*>(&meshes);
  if (!primitives.empty()) root_ = uintptr_t(rtcBuildBVH(&build));
  device.check_build("the occluders of luminaires");
}

bool OccluderTree::find(const LuminaireView& view, uint32_t most, std::vector<Occluder>& out) const {
  return find_in(root_, view, Shaft(view), most, out);
}

}  // namespace penumbra
