// SPDX-License-Identifier: GPL-3.0-or-later
// Rays against the placed geometry, and exact surface points from their hits.
#include "visibility/geometry.h"

#include <limits>

namespace penumbra {
namespace {

/// Cuts t_near and t_far to where the ray is inside the box, so that a camera far away still starts its
/// single-precision rays near the scene. False where it misses. The box is widened by a rounding error.
bool clip_to_box(const Box& box, Ray& ray) {
  const double margin = 1e-6 * (1 + max_abs(box.extent()));
  for (int axis = 0; axis < 3; ++axis) {
    const double o = ray.origin[axis], d = ray.direction[axis];
    const double low = box.low[axis] - margin, high = box.high[axis] + margin;
    if (d == 0) {
      if (o < low || o > high) return false;
      continue;
    }
    const double a = (low - o) / d, b = (high - o) / d;
    ray.t_near = std::max(ray.t_near, std::min(a, b));
    ray.t_far = std::min(ray.t_far, std::max(a, b));
  }
  return ray.t_near <= ray.t_far;
}

struct Barycentric {
  double u, v, t;
};

/// Where the line of the ray meets the triangle's plane (Möller and Trumbore 1997), the point moved into
/// the triangle if rounding put it outside.
Barycentric intersect_plane(const Vec3d& origin, const Vec3d& direction, const Vec3d& a, const Vec3d& edge1,
                            const Vec3d& edge2) {
  const Vec3d p = cross(direction, edge2);
  const double determinant = dot(edge1, p);
  if (determinant == 0) return {0, 0, 0};
  const Vec3d s = origin - a, q = cross(s, edge1);
  double u = std::clamp(dot(s, p) / determinant, 0.0, 1.0);
  double v = std::clamp(dot(direction, q) / determinant, 0.0, 1.0);
  if (u + v > 1) {
    u /= u + v;
    v = 1 - u;
  }
  return {u, v, dot(edge2, q) / determinant};
}

/// Embree's own error in where a triangle is, relative to the coordinates it computes with, some ulps of
/// single precision. Measured by the self-shadowing and leak tests of
/// tests/hard_cases/test_b_acne_and_leaks.py.
constexpr double kRelativeRounding = 0x1p-21;

}  // namespace

void Geometry::intersect(const Ray* rays, uint32_t active, Hit* hits) const {
  constexpr int kWidth = 16;
  alignas(64) RTCRayHit16 packet;
  alignas(64) int valid[kWidth];
  bool any = false;
  for (int i = 0; i < kWidth; ++i) {
    valid[i] = 0;
    if (!(active >> i & 1)) continue;
    hits[i] = Hit{};
    Ray ray = rays[i];
    if (bounds_.empty() || !is_finite(ray.origin) || !is_finite(ray.direction) ||
        max_abs(ray.direction) == 0 || !clip_to_box(bounds_, ray))
      continue;
    // Embree refuses directions beyond 1.8e18: their exponent is taken out.
    const int exponent = std::ilogb(max_abs(ray.direction));
    const double shrink = std::scalbn(1.0, -exponent);
    const Vec3f origin(ray.origin + ray.direction * ray.t_near), direction(ray.direction * shrink);
    const float length = float((ray.t_far - ray.t_near) / shrink);
    if (!is_finite(origin) || !is_finite(direction) || !std::isfinite(length) || max_abs(direction) == 0)
      continue;
    valid[i] = -1;
    any = true;
    packet.ray.org_x[i] = origin.x, packet.ray.org_y[i] = origin.y, packet.ray.org_z[i] = origin.z;
    packet.ray.dir_x[i] = direction.x, packet.ray.dir_y[i] = direction.y, packet.ray.dir_z[i] = direction.z;
    packet.ray.tnear[i] = 0, packet.ray.tfar[i] = length;
    packet.ray.time[i] = 0, packet.ray.mask[i] = ray.mask, packet.ray.id[i] = unsigned(i), packet.ray.flags[i] = 0;
    packet.hit.geomID[i] = packet.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
  }
  if (!any) return;
  embree::intersect16(valid, scene_.get(), packet, !has_shared_meshes_);
  for (int i = 0; i < kWidth; ++i) {
    if (!valid[i] || packet.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) continue;
    const bool instanced = packet.hit.instID[0][i] != RTC_INVALID_GEOMETRY_ID;
    hits[i] = {instanced ? packet.hit.instID[0][i] : packet.hit.geomID[i], packet.hit.primID[i]};
  }
}

SurfacePoint Geometry::surface_point(const Ray& ray, const Hit& hit) const {
  const PlacedInstance& instance = instances_[hit.instance];
  const PlacedMesh& mesh = *meshes_[instance.mesh];
  const auto& corners = mesh.triangles[hit.triangle];
  const Vec3d a(mesh.positions[corners[0]]), b(mesh.positions[corners[1]]), c(mesh.positions[corners[2]]);
  const Vec3d edge1 = b - a, edge2 = c - a;

  const Affine& render_from_mesh = instance.render_from_mesh;
  const Vec3d origin = instance.shared ? render_from_mesh.inverse_point(ray.origin) : ray.origin;
  const Vec3d direction = instance.shared ? render_from_mesh.inverse_vector(ray.direction) : ray.direction;
  const Barycentric h = intersect_plane(origin, direction, a, edge1, edge2);

  SurfacePoint s;
  s.t = h.t;
  const Vec3d in_mesh = a + edge1 * h.u + edge2 * h.v;
  s.position = render_from_mesh.point(in_mesh);
  // The cofactor matrix turns normals with the determinant's sign; outward stays outward.
  const double orientation = instance.render_from_object.determinant() < 0 ? -1 : 1;
  Vec3d geometric = cross(edge1, edge2);
  if (instance.shared) geometric = render_from_mesh.normal(geometric);
  s.geometric_normal = normalize(geometric) * orientation;
  s.normal = s.geometric_normal;
  if (!mesh.corner_normals.empty()) {
    const Vec3f* n = &mesh.corner_normals[3 * size_t(hit.triangle)];
    const auto placed = [&](const Vec3d& normal) {
      return normalize(instance.render_from_object.normal(normal)) * orientation;
    };
    // As Cycles does: a mesh used once is interpolated where it is placed, a shared one in its own space.
    // Under a stretching transform the two differ a little; neither is more right.
    const double weights[3] = {1 - h.u - h.v, h.u, h.v};
    Vec3d interpolated;
    for (int i = 0; i < 3; ++i)
      interpolated += (instance.shared ? Vec3d(n[i]) : placed(Vec3d(n[i]))) * weights[i];
    const Vec3d smooth = instance.shared ? placed(interpolated) : normalize(interpolated);
    if (is_finite(smooth) && dot(smooth, smooth) > 0) s.normal = smooth;
  }
  s.place = {&mesh.attributes,
             &normalization_,
             &instance.render_from_object,
             &render_from_mesh,
             edge1,
             edge2,
             hit.triangle,
             h.u,
             h.v,
             dot(s.geometric_normal, ray.direction) > 0};
  if (s.place.backfacing) {
    s.geometric_normal = -s.geometric_normal;
    s.normal = -s.normal;
  }

  const double extent = instance.shared ? instance.extent : std::max(max_abs(edge1), max_abs(edge2));
  s.rounding = kRelativeRounding * (max_abs(s.position) + extent);
  const uint32_t slot = mesh.material_slots.empty() ? 0 : mesh.material_slots[hit.triangle];
  s.material = instance.materials[std::min<size_t>(slot, instance.materials.size() - 1)];
  s.receiver_set = instance.receiver_set;
  return s;
}

}  // namespace penumbra
