// SPDX-License-Identifier: GPL-3.0-or-later
// The kinds of luminaires a scene can have, in world space.
#pragma once

#include <array>
#include <cstdint>
#include <numbers>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "math/transform.h"
#include "scene/object_traits.h"
#include "scene/ray_mask.h"

namespace penumbra {

/// What a luminaire is to rays and surfaces, beside its light.
struct LuminaireRole {
  bool to_camera = false, in_mirrors = false;  // it is seen itself (one of a mesh is a surface, seen as such)
  bool diffuse = true, glossy = true;          // kinds of lobes that it lights
  RayMask shadow_rays = kShadowRay;            // which objects hide it
  std::vector<bool> receivers;  // by Instance::receiver_set, whether it lights those; none: all
};

enum class LuminaireShape { kRectangle, kEllipse };

/// A flat luminaire of constant radiance, centred in its local xy plane and emitting towards local -z.
struct AreaLuminaire {
  std::string name;
  LuminaireShape shape;
  Affine world_from_light;
  double size_x, size_y;  // full extents in local space
  Vec3d radiance;         // W / (sr m^2); its mean over all directions, cosine-weighted
  bool cast_shadow = true;
  double spread = std::numbers::pi;  // full angle of the cone that light leaves in, radians
  LuminaireRole role = {};
};

/// The cone of a spot around the light's local -z: full inside, none outside `angle`, and between them
/// smoothstep((cos - cos(angle / 2)) / ((1 - cos(angle / 2)) blend)) of the direction's cosine, taken in the
/// light's own axes.
struct SpotCone {
  double angle, blend;          // full angle in radians, 0 ... pi; share of it, 0 ... 1
  bool cosine_falloff = false;  // times the cosine itself
};

enum class RoundShape { kSphere, kFacingDisk };

/// A luminaire around a point: a sphere, or a disk that faces whoever looks at it. Its radiance is
/// intensity / (pi radius^2); of radius 0 it is a point.
struct PointLuminaire {
  std::string name;
  RoundShape shape;
  Affine world_from_light;  // the axes count for the spot's cone alone
  double radius;            // world units, not scaled by the transform
  Vec3d intensity;          // W / sr
  bool cast_shadow = true;
  std::optional<SpotCone> spot;
  LuminaireRole role = {};
};

/// A disk of directions, infinitely far away, of constant radiance; of angle 0 one direction.
struct SunLuminaire {
  std::string name;
  Vec3d to_sun;       // any length
  double half_angle;  // radians, 0 ... pi / 2
  Vec3d irradiance;   // W / m^2 of a surface that faces it
  bool cast_shadow = true;
  LuminaireRole role = {};
};

/// Triangles of constant radiance, on both sides or on that of their normals. The same triangles are part of
/// the scene's geometry.
struct MeshLuminaire {
  std::string name;
  std::vector<Vec3d> positions;  // world space
  std::vector<std::array<uint32_t, 3>> triangles;
  Vec3d radiance;  // W / (sr m^2)
  bool cast_shadow = true;
  LuminaireRole role = {};
  std::vector<float> weights = {};  // by triangle, what the radiance is multiplied with; none: 1
  bool one_sided = false;
};

/// All triangles of an instance whose materials' emission varies over the surface.
struct TexturedLuminaire {
  std::string name;
  uint32_t instance;
  LuminaireRole role = {};
  uint32_t light_group = kNoLightGroup;  // given by the scene
};

using LuminaireDescription = std::variant<AreaLuminaire, PointLuminaire, SunLuminaire, MeshLuminaire>;

}  // namespace penumbra
