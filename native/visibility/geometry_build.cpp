// SPDX-License-Identifier: GPL-3.0-or-later
// Placing a scene's meshes in render space and building Embree's BVH over them.
#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

#include "visibility/geometry.h"
#include "visibility/occluder_tree.h"
#include "visibility/useless_triangles.h"

namespace penumbra {
namespace {

Box transformed(const Box& box, const Affine& transform) {
  Box result;
  if (!box.empty())
    for (const Vec3d& corner : box.corners()) result.include(transform.point(corner));
  return result;
}

/// Embree carries rays into the space of a shared mesh, in single precision: where axes are nearly dependent
/// its inverse is infinite, as where the determinant leaves the range of float, and it refuses (and aborts
/// at) directions beyond 1.8e18.
bool has_usable_inverse(const Affine& t) {
  constexpr double kMost = 1e17, kLeastVolume = 1e-5, kLeastDeterminant = 1e-36, kMostDeterminant = 1e36;
  const double determinant = std::abs(t.determinant());
  if (!(determinant > kLeastDeterminant && determinant < kMostDeterminant)) return false;
  if (!(determinant > kLeastVolume * length(t.x_axis) * length(t.y_axis) * length(t.z_axis))) return false;
  for (const Vec3d& axis : {Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}})
    if (!(max_abs(t.inverse_vector(axis)) < kMost)) return false;
  return true;
}

/// At all times between two poses, where Embree mixes them entry by entry: a mirrored one is met through
/// zero.
bool has_usable_inverse(const Affine& from, const Affine& to) {
  if ((from.determinant() > 0) != (to.determinant() > 0)) return false;
  for (const double share : {0.25, 0.5, 0.75})
    if (!has_usable_inverse(mixed(from, to, share))) return false;
  return true;
}

/// Something left out in several places: how often, and where first.
struct LeftOut {
  size_t count = 0, places = 0;
  std::string first;

  void add(size_t n, const std::string& name) {
    if (n == 0) return;
    if (places++ == 0) first = name;
    count += n;
  }
  /// "COUNT WHAT were left out, of NAME [and N others]".
  void tell(const std::string& what, std::vector<std::string>& notes) const {
    if (count == 0) return;
    std::string text = std::to_string(count) + " " + what + " left out: '" + first + "'";
    if (places > 1) text += " and " + std::to_string(places - 1) + " more";
    notes.push_back(std::move(text));
  }
};

std::shared_ptr<embree::CountedDevice> device_for(const std::vector<Mesh>& meshes, uint64_t memory_limit) {
  for (const Mesh& mesh : meshes) {
    if (!mesh.kept) continue;
    mesh.kept->device()->memory.set_limit(memory_limit);
    return mesh.kept->device();
  }
  return std::make_shared<embree::CountedDevice>(memory_limit);
}

}  // namespace

Geometry::Geometry(std::vector<Mesh> meshes, std::vector<Instance> instances, uint64_t memory_limit,
                   std::shared_ptr<const Opacity> opacity)
    : opacity_(std::move(opacity)), device_(device_for(meshes, memory_limit)) {
  std::vector<uint32_t> users(meshes.size(), 0);
  for (const Instance& instance : instances) ++users[instance.mesh];
  clean(meshes, users);
  std::vector<bool> may_be_transparent(meshes.size(), false);
  if (opacity_)
    for (const Instance& instance : instances)
      for (const uint32_t material : instance.materials)
        if (opacity_->may_be_transparent(material)) may_be_transparent[instance.mesh] = true;
  Box world;
  std::vector<Box> mesh_boxes;
  for (const Mesh& mesh : meshes) mesh_boxes.push_back(mesh.kept ? mesh.kept->box() : bounds_of(mesh));
  std::vector<bool> moves(meshes.size(), false);
  std::vector<Box> boxes;
  for (const Instance& instance : instances) {
    Box box = transformed(mesh_boxes[instance.mesh], instance.world_from_object);
    for (const Affine& pose : instance.motion) box.include(transformed(mesh_boxes[instance.mesh], pose));
    world.include(box);
    boxes.push_back(box);
    if (!instance.motion.empty()) moves[instance.mesh] = true;
  }
  if (!world.empty()) normalization_ = {world.centre(), unit_scale(world)};
  if (!is_finite(normalization_.centre) || !std::isfinite(normalization_.scale) || normalization_.scale == 0)
    throw std::invalid_argument("the scene's extent is not finite");
  note_what_rounding_loses(instances, boxes);

  scene_.reset(rtcNewScene(device_->device.get()));
  rtcSetSceneFlags(scene_.get(), RTC_SCENE_FLAG_ROBUST);
  meshes_.resize(meshes.size());
  for (size_t i = 0; i < meshes.size(); ++i)
    if (users[i] > 1 ||
        (users[i] && (meshes[i].kept || moves[i])))  // others are placed with their one instance below
      meshes_[i] = place_shared(meshes[i], mesh_boxes[i], may_be_transparent[i]);

  LeftOut flat;
  for (Instance& instance : instances) {
    const Box& box = mesh_boxes[instance.mesh];
    PlacedInstance placed{.name = std::move(instance.name),
                          .mesh = instance.mesh,
                          .render_from_mesh = {},
                          .render_from_object = normalization_.transform(instance.world_from_object),
                          .orientation = 1,
                          .extent = 0,
                          .shared = meshes_[instance.mesh] != nullptr,
                          .materials = std::move(instance.materials),
                          .receiver_set = instance.receiver_set,
                          .traits = instance.traits};
    for (const Affine& pose : subdivided(instance.motion))
      placed.object_motion.push_back(normalization_.transform(pose));
    has_shared_meshes_ = has_shared_meshes_ || placed.shared;
    const double determinant = placed.render_from_object.determinant();
    placed.orientation = determinant < 0 ? -1 : 1;
    // A scale of zero leaves nothing to be seen, as in Cycles.
    const bool has_volume = determinant != 0;
    const auto id = unsigned(instances_.size());
    RTCGeometry geometry = nullptr;
    if (!placed.shared) {
      Mesh& source = meshes[instance.mesh];
      auto mesh = std::make_shared<PlacedMesh>();
      mesh->may_be_transparent = may_be_transparent[instance.mesh];
      mesh->take_positions(source, placed.render_from_object);
      mesh->take(source);
      if (has_volume && mesh->primitives()) {
        // As Cycles does: a mesh used once is interpolated where it is placed, a shared one in its own space.
        // Under a stretching transform the two differ a little; neither is more right.
        const auto place = [&](std::vector<Vec3f>& normals) {
          for (Vec3f& n : normals)
            n = Vec3f(normalize(placed.render_from_object.normal(Vec3d(n))) * placed.orientation);
        };
        place(mesh->corner_normals);
        for (std::vector<Vec3f>& normals : mesh->normal_motion) place(normals);
        mesh->split_long();
        geometry = mesh->make_geometry(device_->device.get());
      }
      meshes_[instance.mesh] = std::move(mesh);
    }
    const PlacedMesh& mesh = *meshes_[instance.mesh];
    if (placed.shared && has_volume && mesh.primitives()) geometry = make_instance(placed, mesh, box);
    if (!geometry && mesh.primitives()) flat.add(1, placed.name);
    if (geometry) {
      rtcSetGeometryMask(geometry, instance.rays);
      rtcCommitGeometry(geometry);
      rtcAttachGeometryByID(scene_.get(), geometry, id);
      rtcReleaseGeometry(geometry);
      device_->check_build(placed.name);
      bounds_.include(transformed(box, placed.render_from_object));
      for (const Affine& pose : placed.object_motion) bounds_.include(transformed(box, pose));
      moves_ = moves_ || !placed.object_motion.empty() || mesh.deforms();
      triangle_count_ += mesh.primitives();
      has_strands_ = has_strands_ || mesh.strands != StrandShape::kNone;
      all_cast_shadows_ = all_cast_shadows_ && instance.rays & kShadowRay;
    }
    instances_.push_back(std::move(placed));
  }
  flat.tell("objects whose scale is zero in some direction were", notes_);
  meshes.clear();  // the positions in double are not needed while Embree builds
  meshes.shrink_to_fit();
  rtcCommitScene(scene_.get());
  device_->check_build("the whole scene");
}

Geometry::~Geometry() = default;

const OccluderTree* Geometry::occluders() const {
  if (has_shared_meshes_ || moves_ || has_strands_ || has_transparency() || !all_cast_shadows_ ||
      device_->memory.limit() > 0)
    return nullptr;
  std::call_once(occluders_wanted_, [this] {
    std::vector<const PlacedMesh*> meshes;
    for (const PlacedInstance& instance : instances_)
      if (instance.render_from_object.determinant() != 0) meshes.push_back(meshes_[instance.mesh].get());
    occluders_ = std::make_unique<OccluderTree>(*device_, meshes);
  });
  return occluders_.get();
}

/// A stray object can make the scene so large that single precision knows nothing of the others' shapes.
void Geometry::note_what_rounding_loses(const std::vector<Instance>& instances,
                                        const std::vector<Box>& boxes) {
  constexpr double kLost = 1e-6, kLeastSize = 4e-6;  // of the scene's extent; the README's limits
  std::vector<double> sizes;
  double reach = 0;
  size_t farthest = 0;
  for (const Box& box : boxes)
    if (!box.empty() && max_abs(box.extent()) > 0) sizes.push_back(max_abs(box.extent()));
  if (sizes.empty()) return;
  std::nth_element(sizes.begin(), sizes.begin() + std::ptrdiff_t(sizes.size() / 2), sizes.end());
  const double size = sizes[sizes.size() / 2], extent = 1 / normalization_.scale;
  if (size >= kLeastSize * extent) return;
  for (size_t i = 0; i < boxes.size(); ++i) {
    if (boxes[i].empty()) continue;
    const double far = std::max(max_abs(boxes[i].low), max_abs(boxes[i].high));
    if (far > reach) reach = far, farthest = i;
  }
  std::ostringstream text;
  text << "'" << instances[farthest].name << "' reaches so far (" << reach
       << " m) that shapes and gaps of other objects below " << kLost * extent << " m are lost";
  notes_.push_back(text.str());
}

/// A mesh that is placed by instances of its own BVH.
std::shared_ptr<const PlacedMesh> Geometry::place_shared(Mesh& mesh, const Box& box,
                                                         bool may_be_transparent) const {
  if (mesh.kept) return mesh.kept->placed(may_be_transparent);
  auto made = std::make_shared<PlacedMesh>();
  made->may_be_transparent = may_be_transparent;
  made->take_positions(mesh, unit_from_object(box));
  made->take(mesh);
  made->build(*device_, mesh.name);
  return made;
}

/// Takes out what no ray needs, and notes it.
void Geometry::clean(std::vector<Mesh>& meshes, const std::vector<uint32_t>& users) {
  LeftOut without_area, copies, strands;
  for (size_t i = 0; i < meshes.size(); ++i) {
    if (!users[i]) continue;
    strands.add(meshes[i].useless_strands, meshes[i].name);
    if (!meshes[i].motion.empty() || meshes[i].strands != StrandShape::kNone) continue;
    const UselessTriangles found =
        meshes[i].kept ? meshes[i].kept->left_out() : remove_useless_triangles(meshes[i]);
    without_area.add(found.without_area, meshes[i].name);
    copies.add(found.copies, meshes[i].name);
  }
  without_area.tell("triangles without area were", notes_);
  copies.tell("triangles that are copies of others were", notes_);
  strands.tell("strands or points without extent were", notes_);
}

/// None if the transform has no usable inverse.
RTCGeometry Geometry::make_instance(PlacedInstance& placed, const PlacedMesh& mesh, const Box& box) const {
  const double scale = unit_scale(box);
  const Affine object_from_mesh{{1 / scale, 0, 0}, {0, 1 / scale, 0}, {0, 0, 1 / scale}, box.centre()};
  placed.render_from_mesh = placed.render_from_object * object_from_mesh;
  if (!has_usable_inverse(placed.render_from_mesh)) return nullptr;
  placed.extent = max_abs(transformed(box, placed.render_from_object).extent());
  for (const Affine& pose : placed.object_motion) {
    placed.mesh_motion.push_back(pose * object_from_mesh);
    if (!has_usable_inverse(placed.mesh_motion.back())) return nullptr;
    if (const size_t n = placed.mesh_motion.size();
        n > 1 && !has_usable_inverse(placed.mesh_motion[n - 2], placed.mesh_motion[n - 1]))
      return nullptr;
    placed.extent = std::max(placed.extent, max_abs(transformed(box, pose).extent()));
  }
  RTCGeometry geometry = rtcNewGeometry(device_->device.get(), RTC_GEOMETRY_TYPE_INSTANCE);
  rtcSetGeometryInstancedScene(geometry, mesh.scene.get());
  const std::vector<Affine> still{placed.render_from_mesh};
  const std::vector<Affine>& poses = placed.mesh_motion.empty() ? still : placed.mesh_motion;
  if (poses.size() > 1) rtcSetGeometryTimeStepCount(geometry, unsigned(poses.size()));
  for (size_t i = 0; i < poses.size(); ++i) {
    const Affine& t = poses[i];
    const float columns[12] = {float(t.x_axis.x), float(t.x_axis.y), float(t.x_axis.z), float(t.y_axis.x),
                               float(t.y_axis.y), float(t.y_axis.z), float(t.z_axis.x), float(t.z_axis.y),
                               float(t.z_axis.z), float(t.origin.x), float(t.origin.y), float(t.origin.z)};
    rtcSetGeometryTransform(geometry, unsigned(i), RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, columns);
  }
  return geometry;
}

}  // namespace penumbra
