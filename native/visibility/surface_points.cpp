// SPDX-License-Identifier: GPL-3.0-or-later
// Exact surface points from rays' hits.
#include <cmath>
#include <limits>
#include <optional>

#include "math/simd.h"
#include "visibility/geometry.h"

namespace penumbra {
namespace {

/// Embree's own error in where a triangle is, relative to the coordinates it computes with, some ulps of
/// single precision. Measured by the self-shadowing and leak tests of
/// tests/hard_cases/test_b_acne_and_leaks.py.
constexpr double kRelativeRounding = 0x1p-21;

/// Rays start this share of its radius off a strand, whose surface Embree finds by iteration.
constexpr double kStrandRounding = 1e-3;

// As std::max and max_abs(), whose references the vectoriser does not see through.
inline double larger(double a, double b) {
  return a < b ? b : a;
}
inline double largest(const Vec3d& v) {
  return larger(std::abs(v.x), larger(std::abs(v.y), std::abs(v.z)));
}

/// Where the lines of the rays meet the triangles' planes (Möller and Trumbore 1997), the points moved into
/// the triangles if rounding put them outside.
PENUMBRA_VECTORIZED
void meet_planes(HitColumns& c) {
  for (uint32_t i = 0; i < c.count; ++i) {
    const Vec3d edge1 = c.edge1.get(i), edge2 = c.edge2.get(i), direction = c.direction.get(i),
                corner = c.corner.get(i);
    const Vec3d p = cross(direction, edge2);
    const double determinant = dot(edge1, p);
    const Vec3d s = c.origin.get(i) - corner, q = cross(s, edge1);
    const double a = dot(s, p) / determinant, b = dot(direction, q) / determinant,
                 t = dot(edge2, q) / determinant;
    const double u = a > 0 ? (a < 1 ? a : 1.0) : 0.0, v = b > 0 ? (b < 1 ? b : 1.0) : 0.0;
    const bool beyond = u + v > 1, met = determinant != 0;
    const double inner_u = beyond ? u / (u + v) : u, inner_v = beyond ? 1 - inner_u : v;
    c.u[i] = met ? inner_u : 0.0;
    c.v[i] = met ? inner_v : 0.0;
    c.t[i] = met ? t : 0.0;
    c.position.set(i, corner + edge1 * c.u[i] + edge2 * c.v[i]);
    c.geometric_normal.set(i, cross(edge1, edge2));
  }
}

/// Unit normals on the viewer's side, and how far from the surface rays start.
PENUMBRA_VECTORIZED
void orient(HitColumns& c) {
  for (uint32_t i = 0; i < c.count; ++i) {
    const Vec3d g = c.geometric_normal.get(i), n = c.normal.get(i);
    const double g_length = length(g), n_length = length(n);
    // The cofactor matrix turns normals with the determinant's sign; outward stays outward.
    const Vec3d facet = g / (g_length > 0 ? g_length : 1.0) * c.orientation[i];
    const bool smooth = n_length > 0 && n_length <= std::numeric_limits<double>::max();
    const Vec3d shaded = n / n_length;
    const double side = dot(facet, c.towards.get(i)) > 0 ? -1.0 : 1.0;
    c.geometric_normal.set(i, facet * side);
    c.normal.x[i] = (smooth ? shaded.x : facet.x) * side;
    c.normal.y[i] = (smooth ? shaded.y : facet.y) * side;
    c.normal.z[i] = (smooth ? shaded.z : facet.z) * side;
    c.side[i] = side;
    const double edges = larger(largest(c.edge1.get(i)), largest(c.edge2.get(i)));
    const double extent = c.extent[i] < 0 ? edges : c.extent[i];
    c.rounding[i] = kRelativeRounding * (largest(c.position.get(i)) + extent);
  }
}

/// Facets of one surface: the angle between their normals is smaller than this, and one lies off the other's
/// plane by less than this share of their distance.
constexpr double kSameCosine = 0.9, kSameSlope = 0.2;

}  // namespace

bool same_surface(const Facet& a, const Facet& b) {
  if (a.primitive.instance != b.primitive.instance || a.material != b.material) return false;
  if (a.primitive == b.primitive) return true;
  const double aa = dot(a.normal, a.normal), bb = dot(b.normal, b.normal), ab = dot(a.normal, b.normal);
  const Vec3d between = b.corner - a.corner;
  const double off = dot(between, a.normal);
  return ab * std::abs(ab) >= kSameCosine * kSameCosine * aa * bb &&
         off * off <= kSameSlope * kSameSlope * aa * dot(between, between);
}

double step_between(const Facet& a, const Facet& b) {
  if (a.strand || b.strand) return 1;
  if (!a.flat || !b.flat) return 0;
  const Vec3d across = cross(a.normal, b.normal);
  const double lengths = dot(a.normal, a.normal) * dot(b.normal, b.normal);
  return lengths > 0 ? std::sqrt(dot(across, across) / lengths) : 1;
}

Facet Geometry::facet_of(const Primitive& primitive) const {
  Facet facet;
  if (primitive.instance == Hit::kNone) return facet;
  const PlacedInstance& instance = instances_[primitive.instance];
  const PlacedMesh& mesh = *meshes_[instance.mesh];
  facet.primitive = primitive;
  facet.material = material_of(mesh, instance, primitive.triangle);
  facet.strand = mesh.strands != StrandShape::kNone;
  if (facet.strand) return facet;
  const auto& corners = mesh.triangles[primitive.triangle];
  facet.flat = mesh.corner_normals.empty();
  facet.corner = mesh.position(corners[0], 0.5);
  facet.normal =
      cross(mesh.position(corners[1], 0.5) - facet.corner, mesh.position(corners[2], 0.5) - facet.corner);
  return facet;
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

void Geometry::find_surfaces(const Ray* rays, uint32_t count, HitColumns& c) const {
  c.rays = rays;
  intersect(rays, (1u << count) - 1, c.hits);
  recompute(count, c);
}

void Geometry::recompute(uint32_t count, HitColumns& c) const {
  c.count = 0;
  for (uint32_t i = 0; i < count; ++i) {
    const Hit& hit = c.hits[i];
    if (!hit.found()) continue;
    const PlacedInstance& instance = instances_[hit.instance];
    const PlacedMesh& mesh = *meshes_[instance.mesh];
    if (mesh.strands != StrandShape::kNone) continue;
    const Ray& ray = c.rays[i];
    const auto& corners = mesh.triangles[hit.triangle];
    const Vec3d a = mesh.position(corners[0], ray.time), b = mesh.position(corners[1], ray.time),
                d = mesh.position(corners[2], ray.time);
    const uint32_t k = c.count++;
    c.column[i] = k;
    c.ray[k] = i;
    c.corner.set(k, a);
    c.edge1.set(k, b - a);
    c.edge2.set(k, d - a);
    c.towards.set(k, ray.direction);
    c.orientation[k] = instance.orientation;
    c.extent[k] = instance.shared ? instance.extent : -1;
    if (instance.shared) {
      const Moved moved(instance, ray.time);
      c.origin.set(k, moved.render_from_mesh->inverse_point(ray.origin));
      c.direction.set(k, moved.render_from_mesh->inverse_vector(ray.direction));
    } else {
      c.origin.set(k, ray.origin);
      c.direction.set(k, ray.direction);
    }
  }
  meet_planes(c);
  for (uint32_t k = 0; k < c.count; ++k) set_normal(c, k);
  orient(c);
}

/// The interpolated normal, zero where there is none, and what a shared mesh's transform makes of the column.
void Geometry::set_normal(HitColumns& c, uint32_t k) const {
  const Hit& hit = c.hits[c.ray[k]];
  const double time = c.rays[c.ray[k]].time;
  const PlacedInstance& instance = instances_[hit.instance];
  const PlacedMesh& mesh = *meshes_[instance.mesh];
  Vec3d interpolated;
  if (!mesh.corner_normals.empty()) {
    interpolated = mesh.corner_normal(hit.triangle, 0, time) * (1 - c.u[k] - c.v[k]) +
                   mesh.corner_normal(hit.triangle, 1, time) * c.u[k] +
                   mesh.corner_normal(hit.triangle, 2, time) * c.v[k];
  }
  if (instance.shared) {
    const Moved moved(instance, time);
    c.position.set(k, moved.render_from_mesh->point(c.position.get(k)));
    c.geometric_normal.set(k, moved.render_from_mesh->normal(c.geometric_normal.get(k)));
    interpolated = moved.render_from_object->normal(interpolated) * instance.orientation;
  }
  c.normal.set(k, interpolated);
}

uint32_t Geometry::material_of(const PlacedMesh& mesh, const PlacedInstance& instance, uint32_t triangle) {
  const uint32_t slot = mesh.material_slots.empty() ? 0 : mesh.material_slots[triangle];
  return instance.materials[std::min<size_t>(slot, instance.materials.size() - 1)];
}

void Geometry::surface_point(const HitColumns& c, uint32_t i, SurfacePoint& s) const {
  const Ray& ray = c.rays[i];
  const Hit& hit = c.hits[i];
  const PlacedInstance& instance = instances_[hit.instance];
  const PlacedMesh& mesh = *meshes_[instance.mesh];
  if (mesh.strands != StrandShape::kNone) {
    PlacedPoint placed;
    strand_point(ray, hit, placed);
    s = placed;
    return;
  }
  const uint32_t k = c.column[i];
  s.position = c.position.get(k);
  s.geometric_normal = c.geometric_normal.get(k);
  s.normal = c.normal.get(k);
  s.t = c.t[k];
  s.rounding = c.rounding[k];
  s.material = material_of(mesh, instance, hit.triangle);
  s.receiver_set = instance.receiver_set;
  s.time = ray.time;
}

void Geometry::surface_point(const HitColumns& c, uint32_t i, PlacedPoint& s) const {
  const Hit& hit = c.hits[i];
  const PlacedInstance& instance = instances_[hit.instance];
  const PlacedMesh& mesh = *meshes_[instance.mesh];
  if (mesh.strands != StrandShape::kNone) return strand_point(c.rays[i], hit, s);
  surface_point(c, i, static_cast<SurfacePoint&>(s));
  const uint32_t k = c.column[i];
  set_owner(s.place, mesh, instance, c.rays[i].time);
  s.place.edge1 = c.edge1.get(k);
  s.place.edge2 = c.edge2.get(k);
  s.place.triangle = hit.triangle;
  s.place.u = c.u[k];
  s.place.v = c.v[k];
  s.place.backfacing = c.side[k] < 0;
}

void Geometry::surface_point(const Ray& ray, const Hit& hit, PlacedPoint& s) const {
  HitColumns columns;
  columns.rays = &ray;
  columns.hits[0] = hit;
  recompute(1, columns);
  surface_point(columns, 0, s);
}

/// A ribbon is shaded as the tube that it stands for, as Cycles does, and rays from it start on that tube:
/// towards the light they meet no part of the strand itself.
void Geometry::strand_point(const Ray& ray, const Hit& hit, PlacedPoint& s) const {
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

PlacedPoint Geometry::surface_point(const Hit& hit, double u, double v, bool from_behind) const {
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
  PlacedPoint s;
  surface_point({at[0] + edge1 * u + edge2 * v - direction, direction}, hit, s);
  return s;
}

}  // namespace penumbra
