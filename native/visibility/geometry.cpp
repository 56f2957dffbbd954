// SPDX-License-Identifier: GPL-3.0-or-later
// Rays against the placed geometry, and exact surface points from their hits.
#include "visibility/geometry.h"

#include <limits>
#include <optional>

namespace penumbra {
namespace {

/// Cuts t_near and t_far to where the ray is inside the box, so that a camera far away still starts its
/// single-precision rays near the scene. False where it misses. The box is widened by a rounding error.
bool clip_to_box(const Box& box, Ray& ray) {
  const double margin = 1e-6 * (1 + max_abs(box.extent()));
  for (int axis = 0; axis < 3; ++axis) {
    const double o = ray.origin[axis], d = ray.direction[axis], inverse = 1 / d;
    const double low = box.low[axis] - margin, high = box.high[axis] + margin;
    if (!std::isfinite(inverse)) {  // never leaves the slab, or nearly so
      if (o < low || o > high) return false;
      continue;
    }
    const double a = (low - o) * inverse, b = (high - o) * inverse;
    ray.t_near = std::max(ray.t_near, std::min(a, b));
    ray.t_far = std::min(ray.t_far, std::max(a, b));
  }
  return ray.t_near <= ray.t_far;
}

/// Embree refuses directions beyond 1.8e18, and single precision loses those below 1e-38: their exponent is
/// taken out.
double shrink_of(double size) {
  return size > 1e-9 && size < 1e9 ? 1.0 : std::scalbn(1.0, -std::ilogb(size));
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

/// Rays start this share of its radius off a strand, whose surface Embree finds by iteration.
constexpr double kStrandRounding = 1e-3;

}  // namespace

void Geometry::intersect(const Ray* rays, uint32_t active, Hit* hits) const {
  constexpr int kWidth = 16;
  alignas(64) RTCRayHit16 packet;
  alignas(64) int valid[kWidth];
  double starts[kWidth], shrinks[kWidth];
  bool any = false;
  for (int i = 0; i < kWidth; ++i) {
    valid[i] = 0;
    if (!(active >> i & 1)) continue;
    hits[i] = Hit{};
    Ray ray = rays[i];
    if (bounds_.empty() || !is_finite(ray.origin) || !is_finite(ray.direction) ||
        max_abs(ray.direction) == 0 || !clip_to_box(bounds_, ray))
      continue;
    const double shrink = shrink_of(max_abs(ray.direction));
    const Vec3f origin(ray.origin + ray.direction * ray.t_near), direction(ray.direction * shrink);
    const float length = float((ray.t_far - ray.t_near) / shrink);
    if (!is_finite(origin) || !is_finite(direction) || !std::isfinite(length) || max_abs(direction) == 0)
      continue;
    valid[i] = -1;
    any = true;
    starts[i] = ray.t_near, shrinks[i] = shrink;
    packet.ray.org_x[i] = origin.x, packet.ray.org_y[i] = origin.y, packet.ray.org_z[i] = origin.z;
    packet.ray.dir_x[i] = direction.x, packet.ray.dir_y[i] = direction.y, packet.ray.dir_z[i] = direction.z;
    packet.ray.tnear[i] = 0, packet.ray.tfar[i] = length;
    packet.ray.time[i] = float(ray.time), packet.ray.mask[i] = ray.mask, packet.ray.id[i] = unsigned(i),
    packet.ray.flags[i] = 0;
    packet.hit.geomID[i] = packet.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
  }
  if (!any) return;
  embree::intersect16(valid, scene_.get(), packet, !has_shared_meshes_);
  for (int i = 0; i < kWidth; ++i) {
    if (!valid[i] || packet.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) continue;
    const bool instanced = packet.hit.instID[0][i] != RTC_INVALID_GEOMETRY_ID;
    hits[i] = {instanced ? packet.hit.instID[0][i] : packet.hit.geomID[i], packet.hit.primID[i],
               packet.hit.u[i], starts[i] + double(packet.ray.tfar[i]) * shrinks[i]};
  }
}

/// An instance's transforms at a time.
struct Geometry::Moved {
  Moved(const PlacedInstance& instance, double time)
      : render_from_mesh(&instance.render_from_mesh), render_from_object(&instance.render_from_object) {
    if (instance.object_motion.empty()) return;
    render_from_mesh = &mesh.emplace(at_time(instance.mesh_motion, instance.render_from_mesh, time));
    render_from_object = &object.emplace(at_time(instance.object_motion, instance.render_from_object, time));
  }
  Moved(const Moved&) = delete;
  Moved& operator=(const Moved&) = delete;

  const Affine *render_from_mesh, *render_from_object;
  std::optional<Affine> mesh, object;
};

void Geometry::set_owner(SurfacePlace& place, const PlacedMesh& mesh, const PlacedInstance& instance,
                         double time) const {
  place.attributes = &mesh.attributes;
  place.normalization = &normalization_;
  place.render_from_object = &instance.render_from_object;
  place.render_from_mesh = &instance.render_from_mesh;
  place.object_motion = &instance.object_motion;
  place.mesh_motion = &instance.mesh_motion;
  place.time = time;
}

void Geometry::surface_point(const Ray& ray, const Hit& hit, SurfacePoint& s) const {
  const PlacedInstance& instance = instances_[hit.instance];
  const PlacedMesh& mesh = *meshes_[instance.mesh];
  if (mesh.strands != StrandShape::kNone) return strand_point(ray, hit, s);
  const auto& corners = mesh.triangles[hit.triangle];
  const Vec3d a = mesh.position(corners[0], ray.time), b = mesh.position(corners[1], ray.time),
              c = mesh.position(corners[2], ray.time);
  const Vec3d edge1 = b - a, edge2 = c - a;

  const Moved moved(instance, ray.time);
  const Affine &render_from_mesh = *moved.render_from_mesh, &render_from_object = *moved.render_from_object;
  const Vec3d origin = instance.shared ? render_from_mesh.inverse_point(ray.origin) : ray.origin;
  const Vec3d direction = instance.shared ? render_from_mesh.inverse_vector(ray.direction) : ray.direction;
  const Barycentric h = intersect_plane(origin, direction, a, edge1, edge2);

  s.t = h.t;
  Vec3d position = a + edge1 * h.u + edge2 * h.v, geometric = cross(edge1, edge2);
  if (instance.shared) {
    position = render_from_mesh.point(position);
    geometric = render_from_mesh.normal(geometric);
  }
  // The cofactor matrix turns normals with the determinant's sign; outward stays outward.
  geometric = normalize(geometric) * instance.orientation;
  Vec3d normal = geometric;
  if (!mesh.corner_normals.empty()) {
    const size_t n = 3 * size_t(hit.triangle);
    Vec3d interpolated = mesh.corner_normal(n, ray.time) * (1 - h.u - h.v) +
                         mesh.corner_normal(n + 1, ray.time) * h.u +
                         mesh.corner_normal(n + 2, ray.time) * h.v;
    if (instance.shared) interpolated = render_from_object.normal(interpolated) * instance.orientation;
    const Vec3d smooth = normalize(interpolated);
    if (is_finite(smooth) && dot(smooth, smooth) > 0) normal = smooth;
  }
  const bool backfacing = dot(geometric, ray.direction) > 0;
  const double side = backfacing ? -1 : 1;
  // Field by field, from values in registers: what is read back right after it was stored in parts has to
  // wait.
  s.position = position;
  s.geometric_normal = geometric * side;
  s.normal = normal * side;
  set_owner(s.place, mesh, instance, ray.time);
  s.place.edge1 = edge1;
  s.place.edge2 = edge2;
  s.place.triangle = hit.triangle;
  s.place.u = h.u;
  s.place.v = h.v;
  s.place.backfacing = backfacing;

  const double extent = instance.shared ? instance.extent : std::max(max_abs(edge1), max_abs(edge2));
  s.rounding = kRelativeRounding * (max_abs(position) + extent);
  const uint32_t slot = mesh.material_slots.empty() ? 0 : mesh.material_slots[hit.triangle];
  s.material = instance.materials[std::min<size_t>(slot, instance.materials.size() - 1)];
  s.receiver_set = instance.receiver_set;
  s.time = ray.time;
}

/// A ribbon is shaded as the tube that it stands for, as Cycles does, and rays from it start on that tube:
/// towards the light they meet no part of the strand itself.
void Geometry::strand_point(const Ray& ray, const Hit& hit, SurfacePoint& s) const {
  const PlacedInstance& instance = instances_[hit.instance];
  const PlacedMesh& mesh = *meshes_[instance.mesh];
  const Moved moved(instance, ray.time);
  const Affine& render_from_mesh = *moved.render_from_mesh;
  const Vec3d origin = instance.shared ? render_from_mesh.inverse_point(ray.origin) : ray.origin;
  const Vec3d direction = instance.shared ? render_from_mesh.inverse_vector(ray.direction) : ray.direction;

  const StrandPlace place = mesh.strand_place(hit.triangle, hit.u, ray.time);
  const Vec3d across = origin + direction * hit.t - place.centre, to_viewer = normalize(-direction);
  Vec3d normal = normalize(across);
  if (mesh.strands == StrandShape::kRibbon) {
    const Vec3d tangent = normalize(place.tangent);
    const Vec3d front = normalize(to_viewer - tangent * dot(tangent, to_viewer)),
                side = cross(tangent, front);
    const double sine = place.radius > 0 ? std::clamp(dot(across, side) / place.radius, -1.0, 1.0) : 0.0;
    normal = side * sine + front * std::sqrt(1 - sine * sine);
  }
  if (!(dot(normal, normal) > 0)) normal = to_viewer;

  s.t = hit.t;
  s.position = render_from_mesh.point(place.centre + normal * place.radius);
  const double orientation = render_from_mesh.determinant() < 0 ? -1 : 1;
  s.geometric_normal = instance.shared ? normalize(render_from_mesh.normal(normal)) * orientation : normal;
  set_owner(s.place, mesh, instance, ray.time);
  s.place.edge1 = place.tangent;
  s.place.edge2 = cross(place.tangent, normal);
  s.place.triangle = hit.triangle;
  s.place.u = s.place.v = 0;
  s.place.backfacing = dot(s.geometric_normal, ray.direction) > 0;
  if (s.place.backfacing) s.geometric_normal = -s.geometric_normal;
  s.normal = s.geometric_normal;
  const double radius = max_abs(render_from_mesh.vector(normal * place.radius));
  s.rounding = kRelativeRounding * (max_abs(s.position) + instance.extent) + kStrandRounding * radius;
  s.material = instance.materials.front();
  s.receiver_set = instance.receiver_set;
  s.time = ray.time;
}

uint32_t Geometry::triangles_of(uint32_t instance) const {
  const PlacedInstance& placed = instances_[instance];
  const bool visible = placed.render_from_object.determinant() != 0;
  return visible ? uint32_t(meshes_[placed.mesh]->triangles.size()) : 0;
}

SurfacePoint Geometry::surface_point(const Hit& hit, double u, double v, bool from_behind) const {
  const PlacedInstance& instance = instances_[hit.instance];
  const PlacedMesh& mesh = *meshes_[instance.mesh];
  const auto& corners = mesh.triangles[hit.triangle];
  Vec3d at[3];
  for (int i = 0; i < 3; ++i) {
    at[i] = Vec3d(mesh.positions[corners[i]]);
    if (instance.shared) at[i] = instance.render_from_mesh.point(at[i]);
  }
  const Vec3d edge1 = at[1] - at[0], edge2 = at[2] - at[0];
  // Straight down on it, from about a triangle's size away.
  const Vec3d across = cross(edge1, edge2) * instance.orientation, down = from_behind ? across : -across;
  const double size = std::max(max_abs(edge1), max_abs(edge2));
  const Vec3d direction = normalize(down) * size;
  SurfacePoint s;
  surface_point({at[0] + edge1 * u + edge2 * v - direction, direction}, hit, s);
  return s;
}

}  // namespace penumbra
