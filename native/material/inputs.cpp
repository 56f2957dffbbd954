// SPDX-License-Identifier: GPL-3.0-or-later
// Operations that read the surface and the ray: coordinates, attributes, normals, Fresnel, bumps.
#include <cmath>

#include "material/energy.h"
#include "material/lobes.h"
#include "material/machine.h"

namespace penumbra {
namespace {

void position(Machine& m, const Operation& o) {
  m.set(o, m.surface(o).position);
}

void object_position(Machine& m, const Operation& o) {
  m.set(o, m.surface(o).object_position);
}

/// data: number of the attribute's name. Its fourth component, alpha, goes to the second register; zero where
/// the mesh has no such attribute.
void attribute(Machine& m, const Operation& o) {
  const float u = m.surface(o).u, v = m.surface(o).v, weights[3] = {1 - u - v, u, v};
  float sum[4] = {0, 0, 0, 0};
  for (const Attribute& candidate : *m.place->attributes) {
    if (candidate.name != uint32_t(o.data)) continue;
    const auto* corners = &candidate.corners[3 * size_t(m.place->triangle)];
    for (int corner = 0; corner < 3; ++corner)
      for (int i = 0; i < 4; ++i) sum[i] += weights[corner] * corners[corner][size_t(i)];
  }
  m.set(o, Vec3f{sum[0], sum[1], sum[2]});
  m.set_second(o, sum[3]);
}

Vec3f object_from_normal(const Machine& m, const Vec3f& normal) {
  const Affine t = m.place->render_from_object_now();
  const Vec3d n(normal);
  return Vec3f(normalize(Vec3d{dot(t.x_axis, n), dot(t.y_axis, n), dot(t.z_axis, n)}));
}

Vec3f normal_from_object(const Machine& m, const Vec3f& normal) {
  const Affine t = m.place->render_from_object_now();
  const double orientation = t.determinant() < 0 ? -1 : 1;
  return Vec3f(normalize(t.normal(Vec3d(normal))) * orientation);
}

void normal(Machine& m, const Operation& o) {
  m.set(o, m.normal);
}
void true_normal(Machine& m, const Operation& o) {
  m.set(o, m.geometric_normal);
}
void object_normal(Machine& m, const Operation& o) {
  m.set(o, object_from_normal(m, m.normal));
}
void incoming(Machine& m, const Operation& o) {
  m.set(o, m.incoming);
}
void reflection(Machine& m, const Operation& o) {
  m.set(o, -reflect(m.incoming, m.normal));
}
void parametric(Machine& m, const Operation& o) {
  const SurfaceSample& s = m.surface(o);
  m.set(o, Vec3f{1 - s.u - s.v, s.u, 0});
}
void backfacing(Machine& m, const Operation& o) {
  m.set(o, m.place->backfacing ? 1.0f : 0.0f);
}
template <RayKind kind>
void is_ray(Machine& m, const Operation& o) {
  m.set(o, m.ray == kind ? 1.0f : 0.0f);
}

/// Inputs: index of refraction, normal.
void fresnel(Machine& m, const Operation& o) {
  const float ior = std::max(m.number(o, 0), 1e-5f);
  m.set(o, fresnel_dielectric(dot(m.incoming, m.in(o, 1)), m.place->backfacing ? 1 / ior : ior));
}

/// Inputs: blend, normal. Both outputs of the Layer Weight node.
void layer_weight(Machine& m, const Operation& o) {
  const float ior = std::max(1 - m.number(o, 0), 1e-5f);
  m.set(o, fresnel_dielectric(dot(m.incoming, m.in(o, 1)), m.place->backfacing ? ior : 1 / ior));
  float facing = std::abs(dot(m.incoming, m.in(o, 1))), blend = m.number(o, 0);
  if (blend != 0.5f) {
    blend = std::clamp(blend, 0.0f, 1 - 1e-5f);
    facing = std::pow(facing, blend < 0.5f ? 2 * blend : 0.5f / (1 - blend));
  }
  m.set_second(o, 1 - facing);
}

/// Inputs: reflectance, roughness, normal. The reflectance with the light that is scattered more than once:
/// Turquin 2019, "Practical multiple scattering compensation for microfacet models", coloured as by Kulla and
/// Conty 2017.
void multiple_scattering(Machine& m, const Operation& o) {
  const float roughness = std::clamp(m.number(o, 1), 0.0f, 1.0f);
  const float e = ggx_albedo(std::abs(dot(m.incoming, m.in(o, 2))), roughness),
              mean = mean_ggx_albedo(roughness);
  const auto one = [&](float c) { return c * (1 + c * mean / (1 - c * (1 - mean)) * (1 - e) / e); };
  const Vec3f& c = m.in(o, 0);
  m.set(o, Vec3f{one(c.x), one(c.y), one(c.z)});
}

/// Inputs: roughness, index of refraction, normal.
void dielectric(Machine& m, const Operation& o) {
  const float roughness = std::clamp(m.number(o, 0), 0.0f, 1.0f);
  m.set(o, dielectric_albedo(std::abs(dot(m.incoming, m.in(o, 2))), roughness, m.number(o, 1)));
}

/// Inputs: strength, distance (negative: inverted), the height here and beside, normal. Mikkelsen 2010, "Bump
/// mapping unparametrized surfaces on the GPU".
void bump(Machine& m, const Operation& o) {
  const Vec3f dx = m.at[1].position - m.at[0].position, dy = m.at[2].position - m.at[0].position;
  const Vec3f& n = m.in(o, 5);
  const Vec3f rx = cross(dy, n), ry = cross(n, dx);
  const float h = m.number(o, 2), determinant = dot(dx, rx);
  const Vec3f gradient = rx * (m.number(o, 3) - h) + ry * (m.number(o, 4) - h);
  const float distance = m.number(o, 1) * (determinant < 0 ? -1.0f : 1.0f);
  const Vec3f bumped = normalize(n * std::abs(determinant) - gradient * distance);
  const float strength = std::max(m.number(o, 0), 0.0f);
  const Vec3f mixed = normalize(bumped * strength + n * (1 - strength));
  m.set(o, max_abs(mixed) > 0 && is_finite(mixed) ? mixed : n);
}

/// Input: a bumped normal. Turned towards the surface's own until the viewer's mirror direction leaves the
/// surface.
void valid_reflection(Machine& m, const Operation& o) {
  const Vec3f bumped = normalize(m.in(o, 0));
  if (!is_finite(bumped) || max_abs(bumped) == 0) return m.set(o, m.normal);
  const float least = std::min(0.9f * dot(m.geometric_normal, m.incoming), 0.01f);
  const auto leaves = [&](const Vec3f& n) {
    return -dot(reflect(m.incoming, n), m.geometric_normal) >= least;
  };
  if (leaves(bumped)) return m.set(o, bumped);
  float low = 0, high = 1;  // share of the geometric normal
  for (int i = 0; i < 20; ++i) {
    const float middle = (low + high) / 2;
    const bool enough = leaves(normalize(bumped * (1 - middle) + m.geometric_normal * middle));
    (enough ? high : low) = middle;
  }
  m.set(o, normalize(bumped * (1 - high) + m.geometric_normal * high));
}

Vec3f with_strength(const Machine& m, const Vec3f& mapped, float strength) {
  const Vec3f n = normalize(m.normal + (mapped - m.normal) * std::max(strength, 0.0f));
  return max_abs(n) > 0 && is_finite(n) ? n : m.normal;
}

/// Inputs: colour, strength, tangent (its sign in the fourth component of the attribute), that sign.
void normal_map_tangent(Machine& m, const Operation& o) {
  const Vec3f c = m.in(o, 0) * 2.0f - Vec3f{1, 1, 1};
  const float side = m.place->backfacing ? -1.0f : 1.0f;
  const Vec3f n = object_from_normal(m, m.normal) * side, tangent = m.in(o, 2);
  if (max_abs(tangent) == 0) return m.set(o, m.normal);
  const Vec3f bitangent = cross(n, tangent) * m.number(o, 3);
  const Vec3f mapped = normal_from_object(m, normalize(tangent * c.x + bitangent * c.y + n * c.z));
  m.set(o, with_strength(m, mapped * side, m.number(o, 1)));
}

/// Inputs: colour, strength. `kFlip`: y and z point the other way, as in Blender's own renders of such maps.
template <bool kObject, bool kFlip>
void normal_map_fixed(Machine& m, const Operation& o) {
  Vec3f c = m.in(o, 0) * 2.0f - Vec3f{1, 1, 1};
  if (kFlip) c.y = -c.y, c.z = -c.z;
  const Vec3f mapped = kObject ? normal_from_object(m, c) : normalize(c);
  m.set(o, with_strength(m, m.place->backfacing ? -mapped : mapped, m.number(o, 1)));
}

constexpr NamedOperation kOperations[] = {
    {"position", position, false},
    {"object_position", object_position, false},
    {"attribute", attribute, false},
    {"normal", normal, false},
    {"true_normal", true_normal, false},
    {"object_normal", object_normal, false},
    {"incoming", incoming, false, DataKind::kNumber, true},
    {"reflection", reflection, false, DataKind::kNumber, true},
    {"parametric", parametric, false},
    {"backfacing", backfacing, false},
    {"is_ray.camera", is_ray<RayKind::kCamera>, false},
    {"is_ray.mirror", is_ray<RayKind::kMirror>, false},
    {"is_ray.shadow", is_ray<RayKind::kShadow>, false},
    {"fresnel", fresnel, false, DataKind::kNumber, true},
    {"layer_weight", layer_weight, false, DataKind::kNumber, true},
    {"multiple_scattering", multiple_scattering, false, DataKind::kNumber, true},
    {"dielectric_albedo", dielectric, false, DataKind::kNumber, true},
    {"bump", bump, false},
    {"valid_reflection", valid_reflection, false, DataKind::kNumber, true},
    {"normal_map.TANGENT", normal_map_tangent, false},
    {"normal_map.OBJECT", normal_map_fixed<true, false>, false},
    {"normal_map.WORLD", normal_map_fixed<false, false>, false},
    {"normal_map.BLENDER_OBJECT", normal_map_fixed<true, true>, false},
    {"normal_map.BLENDER_WORLD", normal_map_fixed<false, true>, false},
};

}  // namespace

std::span<const NamedOperation> input_operations() {
  return kOperations;
}

}  // namespace penumbra
