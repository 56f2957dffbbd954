// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/scene.h"

#include <numbers>
#include <stdexcept>

#include "sampling/hash.h"

namespace penumbra {
namespace {

[[noreturn]] void refuse(const std::string& name, const std::string& reason) {
  throw std::invalid_argument(name + ": " + reason);
}

constexpr double kMostAngle = std::numbers::pi + 1e-6;  // angles come as float32

bool is_albedo(const Vec3d& a) {
  return is_finite(a) && std::min({a.x, a.y, a.z}) >= 0 && max_component(a) <= 1;
}

void check_triangles(const std::string& name, const std::vector<Vec3d>& positions,
                     const std::vector<std::array<uint32_t, 3>>& triangles) {
  for (size_t i = 0; i < positions.size(); ++i)
    if (!is_finite(positions[i])) refuse(name, "vertex " + std::to_string(i) + " is not finite");
  for (size_t i = 0; i < triangles.size(); ++i)
    for (uint32_t index : triangles[i])
      if (index >= positions.size())
        refuse(name, "triangle " + std::to_string(i) + " names vertex " + std::to_string(index) +
                         ", but there are " + std::to_string(positions.size()));
}

uint64_t hash_of_role(uint64_t h, const LuminaireRole& role) {
  const uint32_t values[5] = {role.to_camera, role.in_mirrors, role.diffuse, role.glossy, role.shadow_rays};
  h = hash_bytes(h, values, sizeof(values));
  for (const bool lit : role.receivers) h = hash_of(h, lit);
  return h;
}

/// Which operation a step is does not enter: functions have no numbers that would last.
uint64_t hash_of_program(uint64_t h, const Program& program) {
  h = hash_array(hash_array(h, program.registers), program.tables);
  for (const Operation& operation : program.operations)
    h = hash_of(hash_bytes(h, operation.in.data(), sizeof(operation.in)), uint64_t(operation.data));
  for (const ClosureStep& step : program.closures) h = hash_of(h, uint64_t(step.kind) << 16 | step.colour);
  return h;
}

uint64_t hash_of_traits(uint64_t h, const ObjectTraits& traits) {
  const float numbers[3] = {traits.pass_index, traits.object_matte, traits.asset_matte};
  h = hash_of(hash_bytes(h, numbers, sizeof(numbers)), traits.light_group);
  return hash_of(hash_of(h, traits.holdout), traits.indirect_only);
}

/// Embree's most times.
constexpr size_t kMostPoses = 129;

void check_poses(const std::string& name, size_t count) {
  if (count == 1 || count > kMostPoses) refuse(name, "motion must be told at 2 to 129 times");
}

void check_motion(const Mesh& mesh) {
  check_poses(mesh.name, mesh.motion.size());
  for (const MeshPose& pose : mesh.motion) {
    if (pose.positions.size() != mesh.positions.size() ||
        pose.corner_normals.size() != mesh.corner_normals.size())
      refuse(mesh.name, "the motion has another number of vertices or corners");
    for (const Vec3d& p : pose.positions)
      if (!is_finite(p)) refuse(mesh.name, "a vertex of the motion is not finite");
  }
}

}  // namespace

void check_mesh(const Mesh& mesh) {
  if (mesh.strands == StrandShape::kNone) check_triangles(mesh.name, mesh.positions, mesh.triangles);
  check_motion(mesh);  // strands were checked where they were made (strands.h)
  const size_t normals = mesh.normals_of_vertices ? mesh.positions.size() : 3 * mesh.triangles.size();
  if (!mesh.corner_normals.empty() && mesh.corner_normals.size() != normals)
    refuse(mesh.name, "corner normals do not match the number of triangles");
  if (!mesh.material_slots.empty() && mesh.material_slots.size() != mesh.triangles.size())
    refuse(mesh.name, "material slots do not match the number of triangles");
  for (const Attribute& attribute : mesh.attributes)
    if (attribute.corners.size() != 3 * mesh.triangles.size())
      refuse(mesh.name, "an attribute does not match the number of triangles");
}

uint64_t hash_of(const Mesh& mesh) {
  uint64_t h = 0;
  for (const Attribute& attribute : mesh.attributes)
    h = hash_array(hash_of(h, attribute.name), attribute.corners);
  h = hash_array(hash_array(h, mesh.positions), mesh.triangles);
  for (const MeshPose& pose : mesh.motion) h = hash_array(hash_array(h, pose.positions), pose.corner_normals);
  if (mesh.strands != StrandShape::kNone)
    h = hash_array(hash_array(hash_of(h, uint64_t(mesh.strands)), mesh.radii), mesh.segments);
  if (mesh.normals_of_vertices) h = hash_of(h, 1);
  return hash_array(hash_array(h, mesh.corner_normals), mesh.material_slots);
}

void Scene::check_not_frozen(const std::string& name) const {
  if (frozen_) refuse(name, "the scene was rendered already: meshes and instances can't be added any more");
}

uint32_t Scene::add_mesh(Mesh mesh) {
  check_not_frozen(mesh.name);
  check_mesh(mesh);
  hash_ = hash_of(hash_, hash_of(mesh));
  meshes_.push_back(std::move(mesh));
  return uint32_t(meshes_.size() - 1);
}

uint32_t Scene::add_kept_mesh(std::shared_ptr<KeptMesh> mesh, const std::string& name, uint64_t hash) {
  check_not_frozen(name);
  hash_ = hash_of(hash_, hash);
  meshes_.push_back({});
  meshes_.back().name = name;
  meshes_.back().kept = std::move(mesh);
  return uint32_t(meshes_.size() - 1);
}

uint32_t Scene::add_material(Material material) {
  const std::string& name = material.name;
  if (!is_albedo(material.diffuse)) refuse(name, "the diffuse albedo must lie in 0 ... 1");
  if (!is_albedo(material.phong)) refuse(name, "the Phong albedo must lie in 0 ... 1");
  if (!is_albedo(material.mirror)) refuse(name, "the mirror albedo must lie in 0 ... 1");
  constexpr double kRounding = 1e-6;  // colours come as float32
  if (max_component(material.diffuse + material.phong + material.mirror) > 1 + kRounding)
    refuse(name, "diffuse, Phong and mirror albedo add up to more than 1");
  if (!(material.phong_exponent >= 0 && std::isfinite(material.phong_exponent)))
    refuse(name, "the Phong exponent must be finite and not negative");
  return add_shader(std::move(material));
}

uint32_t Scene::add_shader(Material material) {
  has_mirrors_ = has_mirrors_ || material.may_mirror();
  has_transparency_ = has_transparency_ || material.may_be_transparent();
  has_coloured_transparency_ = has_coloured_transparency_ || material.may_tint();
  hash_ = hash_bytes(hash_, &material.diffuse, sizeof(Vec3d));
  hash_ = hash_bytes(hash_, &material.phong, sizeof(Vec3d));
  hash_ = hash_bytes(hash_, &material.mirror, sizeof(Vec3d));
  hash_ = hash_bytes(hash_, &material.phong_exponent, sizeof(double));
  if (material.program) hash_ = hash_of_program(hash_, *material.program);
  materials_.push_back(std::move(material));
  return uint32_t(materials_.size() - 1);
}

uint32_t Scene::add_image(Image image) {
  check_not_frozen(image.name);
  for (const ImageFile& file : image.files)
    hash_ = hash_bytes(hash_bytes(hash_, file.path.data(), file.path.size()),
                       file.bytes ? file.bytes->data() : nullptr, file.bytes ? file.bytes->size() : 0);
  images_.push_back(std::move(image));
  return uint32_t(images_.size() - 1);
}

uint32_t Scene::add_instance(Instance instance) {
  const std::string& name = instance.name;
  check_not_frozen(name);
  if (instance.mesh >= meshes_.size()) refuse(name, "no mesh with number " + std::to_string(instance.mesh));
  if (!instance.world_from_object.finite()) refuse(name, "the transform is not finite");
  if (instance.materials.empty()) refuse(name, "no material");
  for (uint32_t m : instance.materials)
    if (m >= materials_.size()) refuse(name, "no material with number " + std::to_string(m));
  hash_ = hash_bytes(hash_, &instance.world_from_object, sizeof(Affine));
  hash_ = hash_array(hash_of(hash_, instance.mesh), instance.materials);
  hash_ = hash_of(hash_of(hash_, instance.rays), instance.receiver_set);
  check_poses(name, instance.motion.size());
  for (const Affine& pose : instance.motion)
    if (!pose.finite()) refuse(name, "the transform is not finite at some time");
  if (!instance.motion.empty()) hash_ = hash_array(hash_, instance.motion);
  hash_ = hash_of_traits(hash_, traits_);
  instance.traits = traits_;
  if (traits_.indirect_only) instance.rays &= ~kCameraRay;
  instances_.push_back(std::move(instance));
  return uint32_t(instances_.size() - 1);
}

void Scene::add_luminaire(AreaLuminaire luminaire) {
  const std::string& name = luminaire.name;
  if (!luminaire.world_from_light.finite()) refuse(name, "the transform is not finite");
  if (!(luminaire.size_x >= 0 && luminaire.size_y >= 0 && std::isfinite(luminaire.size_x) &&
        std::isfinite(luminaire.size_y)))
    refuse(name, "the size must be finite and not negative");
  if (!is_finite(luminaire.radiance)) refuse(name, "the radiance is not finite");
  hash_ = hash_bytes(hash_, &luminaire.world_from_light, sizeof(Affine));
  hash_ = hash_bytes(hash_, &luminaire.radiance, sizeof(Vec3d));
  if (!(luminaire.spread >= 0 && luminaire.spread <= kMostAngle))
    refuse(name, "the spread must lie in 0 ... pi");
  const double shape[4] = {double(luminaire.shape), luminaire.size_x, luminaire.size_y, luminaire.spread};
  hash_ = hash_of(hash_bytes(hash_, shape, sizeof(shape)), luminaire.cast_shadow);
  hash_ = hash_of_role(hash_, luminaire.role);
  luminaires_.emplace_back(std::move(luminaire));
  add_to_group();
}

void Scene::add_luminaire(PointLuminaire luminaire) {
  const std::string& name = luminaire.name;
  const Affine& t = luminaire.world_from_light;
  if (!t.finite()) refuse(name, "the transform is not finite");
  if (!(luminaire.radius >= 0 && std::isfinite(luminaire.radius)))
    refuse(name, "the radius must be finite and not negative");
  if (!is_finite(luminaire.intensity)) refuse(name, "the intensity is not finite");
  hash_ = hash_bytes(hash_, &t, sizeof(Affine));
  hash_ = hash_bytes(hash_, &luminaire.intensity, sizeof(Vec3d));
  const double shape[3] = {double(luminaire.shape), luminaire.radius, double(luminaire.cast_shadow)};
  hash_ = hash_bytes(hash_, shape, sizeof(shape));
  if (luminaire.spot) {
    const SpotCone& spot = *luminaire.spot;
    if (!(spot.angle >= 0 && spot.angle <= kMostAngle && spot.blend >= 0 && spot.blend <= 1))
      refuse(name, "the spot's angle must lie in 0 ... pi and its blend in 0 ... 1");
    if (t.determinant() == 0) refuse(name, "a spot's transform must not be singular");
    const double cone[3] = {spot.angle, spot.blend, double(spot.cosine_falloff)};
    hash_ = hash_bytes(hash_, cone, sizeof(cone));
  }
  hash_ = hash_of_role(hash_, luminaire.role);
  luminaires_.emplace_back(std::move(luminaire));
  add_to_group();
}

void Scene::add_luminaire(SunLuminaire luminaire) {
  const std::string& name = luminaire.name;
  if (!is_finite(luminaire.to_sun) || max_abs(luminaire.to_sun) == 0)
    refuse(name, "the direction is not finite or has no length");
  if (!(luminaire.half_angle >= 0 && luminaire.half_angle <= kMostAngle / 2))
    refuse(name, "half the angle must lie in 0 ... pi / 2");
  if (!is_finite(luminaire.irradiance)) refuse(name, "the irradiance is not finite");
  hash_ = hash_bytes(hash_, &luminaire.to_sun, sizeof(Vec3d));
  hash_ = hash_bytes(hash_, &luminaire.irradiance, sizeof(Vec3d));
  hash_ = hash_of(hash_bytes(hash_, &luminaire.half_angle, sizeof(double)), luminaire.cast_shadow);
  hash_ = hash_of_role(hash_, luminaire.role);
  luminaires_.emplace_back(std::move(luminaire));
  add_to_group();
}

void Scene::add_luminaire(MeshLuminaire luminaire) {
  check_triangles(luminaire.name, luminaire.positions, luminaire.triangles);
  if (!is_finite(luminaire.radiance)) refuse(luminaire.name, "the radiance is not finite");
  hash_ = hash_array(hash_array(hash_, luminaire.positions), luminaire.triangles);
  hash_ = hash_of(hash_bytes(hash_, &luminaire.radiance, sizeof(Vec3d)), luminaire.cast_shadow);
  hash_ = hash_of_role(hash_, luminaire.role);
  luminaires_.emplace_back(std::move(luminaire));
  add_to_group();
}

void Scene::add_to_group() {
  luminaire_groups_.push_back(traits_.light_group);
  hash_ = hash_of(hash_, traits_.light_group);
}

uint32_t Scene::add_light_group(std::string name) {
  hash_ = hash_bytes(hash_, name.data(), name.size());
  light_groups_.push_back(std::move(name));
  return uint32_t(light_groups_.size() - 1);
}

void Scene::set_traits(const ObjectTraits& traits) {
  if (traits.light_group != kNoLightGroup && traits.light_group >= light_groups_.size())
    refuse("scene", "no light group with number " + std::to_string(traits.light_group));
  traits_ = traits;
}

void Scene::set_material_ids(uint32_t material, float pass_index, float matte) {
  if (material >= materials_.size()) refuse("scene", "no material with number " + std::to_string(material));
  const float ids[2] = {pass_index, matte};
  hash_ = hash_bytes(hash_of(hash_, material), ids, sizeof(ids));
  materials_[material].pass_index = pass_index;
  materials_[material].matte = matte;
}

void Scene::set_uv_attribute(uint32_t attribute) {
  hash_ = hash_of(hash_, attribute);
  uv_attribute_ = attribute;
}

void Scene::add_luminaire(TexturedLuminaire luminaire) {
  if (luminaire.instance >= instances_.size())
    refuse(luminaire.name, "no instance with number " + std::to_string(luminaire.instance));
  hash_ = hash_of_role(hash_of(hash_, luminaire.instance), luminaire.role);
  luminaire.light_group = traits_.light_group;
  hash_ = hash_of(hash_, luminaire.light_group);
  textured_luminaires_.push_back(std::move(luminaire));
}

void Scene::set_camera(const Camera& camera) {
  const auto check_pose = [](const Affine& pose, const Window& window) {
    if (!pose.finite() || pose.determinant() == 0)
      refuse("camera", "the transform is not finite or is singular");
    if (!(window.left != window.right && window.bottom != window.top &&
          std::isfinite(window.right - window.left) && std::isfinite(window.top - window.bottom)))
      refuse("camera", "the field of view is empty or not finite");
  };
  check_pose(camera.world_from_camera, camera.window);
  check_poses("camera", camera.motion.size());
  if (camera.motion.size() != camera.window_motion.size())
    refuse("camera", "its motion has another number of transforms than of windows");
  for (size_t i = 0; i < camera.motion.size(); ++i) check_pose(camera.motion[i], camera.window_motion[i]);
  double open = 0;
  for (const double share : camera.shutter) {
    if (!(share >= 0 && std::isfinite(share))) refuse("camera", "the shutter is less than closed");
    open += share;
  }
  if (!camera.shutter.empty() && open == 0) refuse("camera", "the shutter never opens");
  if (!(camera.clip_start < camera.clip_end && std::isfinite(camera.clip_start)))
    refuse("camera", "the clip start is not before the clip end");
  const Aperture& aperture = camera.aperture;
  if (!(aperture.radius >= 0 && std::isfinite(aperture.radius)))
    refuse("camera", "the aperture's radius must be finite and not negative");
  if (!(aperture.focus_distance > 0 && std::isfinite(aperture.focus_distance)))
    refuse("camera", "the focus distance must be finite and positive");
  if (!(aperture.ratio > 0 && std::isfinite(aperture.ratio) && std::isfinite(aperture.rotation)))
    refuse("camera", "the aperture's ratio must be finite and positive and its rotation finite");
  camera_ = camera;
  has_camera_ = true;
  hash_ = hash_bytes(hash_, &camera.world_from_camera, sizeof(Affine));
  const Window& window = camera.window;
  const double rest[7] = {double(camera.kind), window.left,       window.right,   window.bottom,
                          window.top,          camera.clip_start, camera.clip_end};
  hash_ = hash_bytes(hash_, rest, sizeof(rest));
  const double lens[5] = {aperture.radius, aperture.focus_distance, double(aperture.blades),
                          aperture.rotation, aperture.ratio};
  if (aperture.radius > 0) hash_ = hash_bytes(hash_, lens, sizeof(lens));
  if (!camera.motion.empty()) hash_ = hash_array(hash_array(hash_, camera.motion), camera.window_motion);
  if (!camera.shutter.empty()) hash_ = hash_array(hash_, camera.shutter);
}

void Scene::set_background(const Background& background) {
  if (!is_finite(background.color)) refuse("background", "the colour is not finite");
  hash_ = hash_of(hash_bytes(hash_, &background.color, sizeof(Vec3d)), background.transparent);
  hash_ = hash_of(hash_of(hash_, background.lights), background.seen_by_camera);
  if (background.light_group != kNoLightGroup && background.light_group >= light_groups_.size())
    refuse("background", "no light group with number " + std::to_string(background.light_group));
  hash_ = hash_of(hash_, background.light_group);
  if (const Environment* sky = background.environment.get()) {
    if (!sky->local_from_world.finite() || sky->local_from_world.determinant() == 0)
      refuse("background", "the picture's rotation is not finite or singular");
    hash_ = hash_of(hash_, sky->picture->hash());
    hash_ = hash_bytes(hash_, &sky->local_from_world, sizeof(Affine));
  }
  background_ = background;
}

const Camera& Scene::camera() const {
  if (!has_camera_) refuse("scene", "there is no camera");
  return camera_;
}

std::pair<std::vector<Mesh>, std::vector<Instance>> Scene::release_geometry() {
  if (frozen_)
    refuse("scene", "building its ray tracing structure failed before, and it can't be built again");
  frozen_ = true;
  return {std::move(meshes_), std::move(instances_)};
}

}  // namespace penumbra
