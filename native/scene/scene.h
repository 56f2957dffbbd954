// SPDX-License-Identifier: GPL-3.0-or-later
// What there is: meshes, instances, luminaires, materials, camera and background, in world space and double.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "scene/attributes.h"
#include "scene/camera.h"
#include "scene/closures.h"
#include "scene/environment.h"
#include "scene/image.h"
#include "scene/luminaires.h"
#include "scene/object_traits.h"
#include "scene/program.h"
#include "scene/ray_mask.h"

namespace penumbra {

class KeptMesh;

/// What of a mesh changes with time.
struct MeshPose {
  std::vector<Vec3d> positions;
  std::vector<Vec3f> corner_normals;  // as the mesh has them
};

/// What strands and points are to rays: ribbons that face them, tubes, or spheres.
enum class StrandShape { kNone, kRibbon, kTube, kSphere };

/// Triangles in object space; or strands: cubic Catmull-Rom curves through keys of a radius each, or spheres.
struct Mesh {
  std::string name;
  std::vector<Vec3d> positions;
  std::vector<std::array<uint32_t, 3>> triangles;  // of strands empty
  std::vector<Vec3f> corner_normals;               // three a triangle, or one a vertex, or none: flat
  std::vector<uint32_t> material_slots;            // one a triangle, or none: slot 0
  std::vector<Attribute> attributes;
  std::shared_ptr<KeptMesh> kept = {};  // stands for all of the above but the name (see placed_mesh.h)
  // At evenly spaced times from the shutter's opening to its closing; empty where only transforms move it.
  std::vector<MeshPose> motion = {};
  StrandShape strands = StrandShape::kNone;
  std::vector<float> radii = {};        // of the positions, where they are strands
  std::vector<uint32_t> segments = {};  // first of four keys of each curve's; of spheres none
  size_t useless_strands = 0;           // that were left out
  bool normals_of_vertices = false;     // corner_normals are: all corners at a vertex share its
};

/// Throws std::invalid_argument, with the mesh's name, if its arrays do not fit together.
void check_mesh(const Mesh& mesh);
/// Of all that matters for a picture.
uint64_t hash_of(const Mesh& mesh);

struct Instance {
  std::string name;
  uint32_t mesh;
  Affine world_from_object;
  std::vector<uint32_t> materials;  // by slot; slots beyond the end use the last one
  RayMask rays = kAnyRay;           // it is there for
  uint32_t receiver_set = 0;        // see LuminaireRole::receivers
  ObjectTraits traits = {};
  std::vector<Affine> motion = {};  // as Mesh::motion; `world_from_object` is that of the shutter's centre
};

/// Closures of a constant material (the paper's BRDF and more, colours scene linear); those of one that
/// varies over the surface come from its program.
struct Material : Closures {
  std::string name;
  std::shared_ptr<const Program> program;           // null: constant
  std::shared_ptr<const Program> shadow_program;    // of it what transparency takes, for shadow rays
  std::shared_ptr<const Program> emission_program;  // and emission; null: `emission` everywhere
  float pass_index = 0, matte = 0;                  // for passes; the matte is Cryptomatte's id

  bool may_be_glossy() const { return program ? program->may_be_glossy() : has_glossy(); }
  bool may_mirror() const { return program ? program->may_mirror() : max_component(mirror) > 0; }
  bool may_be_transparent() const {
    return program ? program->has(ClosureKind::kTransparent) : max_component(transparency) > 0;
  }
  /// What goes through may be of another colour behind it.
  bool may_tint() const {
    if (program) return may_be_transparent() && !program->grey_transparency;
    return transparency.x != transparency.y || transparency.y != transparency.z;
  }
};

/// What is seen beyond all surfaces.
struct Background {
  Vec3d color;
  bool transparent = false;
  std::shared_ptr<const Environment> environment = {};  // times `color`; none: `color` everywhere
  bool lights = false;                                  // it lights the scene
  bool seen_by_camera = true;
  uint32_t light_group = kNoLightGroup;

  Vec3d radiance(const Vec3d& to_sky) const {
    return environment ? color * environment->radiance(to_sky) : color;
  }
};

/// Adders check what they are given and throw std::invalid_argument with the object's name in the text.
class Scene {
 public:
  uint32_t add_mesh(Mesh mesh);
  /// hash: that of the mesh behind it.
  uint32_t add_kept_mesh(std::shared_ptr<KeptMesh> mesh, const std::string& name, uint64_t hash);
  /// The paper's BRDF.
  uint32_t add_material(Material material);
  /// A material that follows Cycles' rules instead: nothing about it is refused.
  uint32_t add_shader(Material material);
  uint32_t add_image(Image image);
  /// Returns its number, as Geometry counts them.
  uint32_t add_instance(Instance instance);
  void add_luminaire(AreaLuminaire luminaire);
  void add_luminaire(PointLuminaire luminaire);
  void add_luminaire(SunLuminaire luminaire);
  void add_luminaire(MeshLuminaire luminaire);
  /// Returns the group's number.
  uint32_t add_light_group(std::string name);
  /// Of the instances and luminaires that are added from now on.
  void set_traits(const ObjectTraits& traits);
  void set_material_ids(uint32_t material, float pass_index, float matte);
  /// Number of the attribute that the pass UV shows.
  void set_uv_attribute(uint32_t attribute);
  void add_luminaire(TexturedLuminaire luminaire);
  void set_camera(const Camera& camera);
  void set_background(const Background& background);

  /// Hands meshes and instances over, once, to whoever builds the acceleration structure. From then on none
  /// can be added; everything else can still change. A second call throws std::invalid_argument.
  std::pair<std::vector<Mesh>, std::vector<Instance>> release_geometry();

  /// Hash of everything that was added, in its order.
  uint64_t hash() const { return hash_; }

  const std::vector<Material>& materials() const { return materials_; }
  const std::vector<Image>& images() const { return images_; }
  const std::vector<LuminaireDescription>& luminaires() const { return luminaires_; }
  uint32_t light_group_of(size_t luminaire) const { return luminaire_groups_[luminaire]; }
  const std::vector<std::string>& light_groups() const { return light_groups_; }
  std::optional<uint32_t> uv_attribute() const { return uv_attribute_; }
  const std::vector<TexturedLuminaire>& textured_luminaires() const { return textured_luminaires_; }
  const Camera& camera() const;
  const Background& background() const { return background_; }
  bool has_mirrors() const { return has_mirrors_; }
  bool has_transparency() const { return has_transparency_; }
  bool has_coloured_transparency() const { return has_coloured_transparency_; }

 private:
  void check_not_frozen(const std::string& name) const;
  void add_to_group();

  std::vector<Mesh> meshes_;
  std::vector<Instance> instances_;
  std::vector<Material> materials_;
  std::vector<Image> images_;
  std::vector<LuminaireDescription> luminaires_;
  std::vector<uint32_t> luminaire_groups_;
  std::vector<std::string> light_groups_;
  std::optional<uint32_t> uv_attribute_;
  ObjectTraits traits_;
  std::vector<TexturedLuminaire> textured_luminaires_;
  Camera camera_;
  Background background_;
  bool has_camera_ = false, has_mirrors_ = false, has_transparency_ = false,
       has_coloured_transparency_ = false, frozen_ = false;
  uint64_t hash_ = 0;
};

}  // namespace penumbra
