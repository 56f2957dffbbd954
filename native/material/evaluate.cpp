// SPDX-License-Identifier: GPL-3.0-or-later
#include "material/evaluate.h"

#include <cmath>

#include "material/lobes.h"

namespace penumbra {
namespace {

/// Reflectance in the mirror direction where microfacets are too smooth to be a lobe.
Vec3f mirror_colour(const Lobe& lobe, float cosine) {
  const float edge = lobe.ior != 0 ? fresnel_edge(cosine, lobe.ior) : 0;
  return lobe.colour * (1 - edge) + lobe.edge * edge;
}

Lobe lobe_of(const ClosureStep& step, const Vec3f* r) {
  Lobe lobe;
  lobe.colour = r[step.colour];
  lobe.edge = r[step.edge];
  lobe.ior = r[step.ior].x;
  lobe.roughness = std::clamp(r[step.roughness].x, 0.0f, 1.0f);
  return lobe;
}

/// Adds a closure. cosine: of the angle between viewer and normal.
void add(const ClosureStep& step, const Vec3f* r, float cosine, Closures& out) {
  Lobe lobe = lobe_of(step, r);
  const bool lambert = step.kind == ClosureKind::kDiffuse && lobe.roughness < 1e-5f;
  if (!is_finite(lobe.colour) || (max_abs(lobe.colour) == 0 && max_abs(lobe.edge) == 0)) return;
  switch (step.kind) {
    case ClosureKind::kDiffuse:
      if (lambert && !out.bumped) {
        out.diffuse += Vec3d(lobe.colour);
        return;
      }
      lobe.kind = lambert ? LobeKind::kLambert : LobeKind::kOrenNayar;
      if (!lambert) lobe.edge = oren_nayar_edge(lobe.colour, lobe.edge, lobe.roughness);
      return out.add(lobe);
    case ClosureKind::kDisney:
      lobe.kind = LobeKind::kDisney;
      return out.add(lobe);
    case ClosureKind::kSheen:
      lobe.kind = LobeKind::kSheen;
      return out.add(lobe);
    case ClosureKind::kGlossy:
    case ClosureKind::kCorrelatedGlossy:
    case ClosureKind::kBeckmann:
    case ClosureKind::kClearcoat:
      lobe.kind =
          LobeKind(int(LobeKind::kGgx) + int(step.kind) - int(ClosureKind::kGlossy));  // in the same order
      lobe.roughness *= lobe.roughness;                                                // alpha
      if (lobe.roughness * lobe.roughness > kMirrorAlphaSquared) return out.add(lobe);
      out.mirror += Vec3d(mirror_colour(lobe, cosine));
      return;
    case ClosureKind::kPhong:
      out.phong += Vec3d(lobe.colour);
      out.phong_exponent = double(r[step.roughness].x);
      return;
    case ClosureKind::kEmission:
      out.emission += Vec3d(lobe.colour);
      return;
    case ClosureKind::kTransparent:
      out.transparency += Vec3d(lobe.colour);
      return;
    case ClosureKind::kHoldout:
      out.holdout += double(lobe.colour.x);
      return;
  }
}

/// The surface beside a point, at `offset` in the plane of its triangle, render space.
SurfaceSample beside(const SurfaceSample& here, const SurfacePlace& place, const Vec3d& offset,
                     double scale) {
  const Vec3d in_mesh = place.render_from_mesh_now().inverse_vector(offset);
  const double ee = dot(place.edge1, place.edge1), ef = dot(place.edge1, place.edge2),
               ff = dot(place.edge2, place.edge2), oe = dot(in_mesh, place.edge1),
               of = dot(in_mesh, place.edge2);
  const double determinant = ee * ff - ef * ef;
  SurfaceSample result = here;
  if (determinant > 0) {
    result.u += float((oe * ff - of * ef) / determinant);
    result.v += float((of * ee - oe * ef) / determinant);
  }
  result.position += Vec3f(offset / scale);
  result.object_position += Vec3f(place.render_from_object_now().inverse_vector(offset));
  return result;
}

/// Two directions that span the plane with this normal: the ones that Cycles takes, since bumps of fewer
/// pixels than two depend on them.
std::pair<Vec3d, Vec3d> plane_axes(const Vec3d& normal) {
  const bool diagonal = normal.x == normal.y && normal.x == normal.z;
  const Vec3d x = normalize(cross(diagonal ? Vec3d{-1, 1, 1} : Vec3d{1, 1, 1}, normal));
  return {x, cross(normal, x)};
}

}  // namespace

bool is_constant(const Program& program) {
  if (!program.operations.empty() || program.normal) return false;
  return std::none_of(program.closures.begin(), program.closures.end(), [&](const ClosureStep& step) {
    const Lobe lobe = lobe_of(step, program.registers.data());
    return is_microfacets(step.kind) && lobe.ior != 0 &&
           std::pow(lobe.roughness, 4.0f) <= kMirrorAlphaSquared;
  });
}

Closures constant_closures(const Program& program) {
  Closures result;
  for (const ClosureStep& step : program.closures) add(step, program.registers.data(), 1, result);
  return result;
}

Materials::Materials(std::shared_ptr<const Scene> scene, TextureStore* store) : scene_(std::move(scene)) {
  const std::vector<Image>& images = scene_->images();
  if (!images.empty())
    textures_ = store ? store->textures_of(images) : std::make_shared<const Textures>(images);
}

bool Materials::may_be_transparent(uint32_t material) const {
  return scene_->materials()[material].may_be_transparent();
}

double Materials::transparency(const PlacedPoint& surface, const Vec3d& direction, uint8_t channel) const {
  const Material& material = scene_->materials()[surface.material];
  Vec3d t = material.transparency;
  if (material.program) {
    PlacedPoint copy = surface;
    t = evaluate(material.shadow_program ? *material.shadow_program : *material.program, copy,
                 {direction, RayKind::kShadow})
            .transparency;
  }
  return std::clamp(channel == kAllChannels ? (t.x + t.y + t.z) / 3 : t[channel], 0.0, 1.0);
}

std::vector<std::string> Materials::problems() const {
  return textures_ ? textures_->problems() : std::vector<std::string>{};
}

Closures Materials::evaluate(const Program& program, PlacedPoint& surface, const Seen& seen) const {
  thread_local std::vector<Vec3f> registers;
  registers.assign(program.registers.begin(), program.registers.end());
  const SurfacePlace& place = surface.place;
  Machine machine{};
  machine.registers = registers.data();
  machine.tables = program.tables.data();
  machine.place = &place;
  machine.at[0] = {Vec3f(place.normalization->world_point(surface.position)),
                   Vec3f(place.render_from_object_now().inverse_point(surface.position)), float(place.u),
                   float(place.v)};
  machine.normal = Vec3f(surface.normal);
  machine.geometric_normal = Vec3f(surface.geometric_normal);
  machine.incoming = Vec3f(normalize(-seen.direction));
  machine.ray = seen.ray;
  machine.textures = textures_.get();
  if (program.looks_beside) {
    const auto [x, y] = plane_axes(surface.geometric_normal);
    machine.at[1] = beside(machine.at[0], place, x * seen.footprint, place.normalization->scale);
    machine.at[2] = beside(machine.at[0], place, y * seen.footprint, place.normalization->scale);
  }
  for (const Operation& operation : program.operations) operation.function(machine, operation);

  Closures result;
  if (program.normal) {
    const Vec3f wanted = normalize(registers[program.normal]);
    const bool usable = is_finite(wanted) && max_abs(wanted) > 0;
    if (usable && !(wanted == machine.normal)) {
      result.bumped = true;
      result.facet_bumps = program.facet_bumps;
      result.smooth_normal = machine.normal;
      surface.normal = Vec3d(wanted);
    }
  }
  const float cosine = float(dot(surface.normal, Vec3d(machine.incoming)));
  for (const ClosureStep& step : program.closures) add(step, registers.data(), cosine, result);
  return result;
}

}  // namespace penumbra
