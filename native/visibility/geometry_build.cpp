// SPDX-License-Identifier: GPL-3.0-or-later
// Placing a scene's meshes in render space and building Embree's BVH over them.
#include <cmath>
#include <stdexcept>

#include "visibility/geometry.h"
#include "visibility/useless_triangles.h"

namespace penumbra {
namespace {

Box bounds_of(const std::vector<Vec3d>& positions) {
  Box box;
  for (const Vec3d& p : positions) box.include(p);
  return box;
}

/// The power of two that brings a box's largest half extent into (1/2, 1]; 1 for a point or nothing.
double unit_scale(const Box& box) {
  const double half = box.empty() ? 0 : max_abs(box.extent()) / 2;
  if (half == 0) return 1;
  return std::exp2(-std::ceil(std::log2(half)));
}

Box transformed(const Box& box, const Affine& transform) {
  Box result;
  if (!box.empty())
    for (const Vec3d& corner : box.corners()) result.include(transform.point(corner));
  return result;
}

/// Rounded to single precision, with one vertex more as padding.
std::vector<Vec3f> rounded(const std::vector<Vec3d>& positions, const Affine& transform) {
  std::vector<Vec3f> result;
  result.reserve(positions.size() + 1);
  for (const Vec3d& p : positions) result.emplace_back(transform.point(p));
  result.emplace_back();
  return result;
}

/// Embree carries rays into the space of a shared mesh, in single precision: where axes are nearly dependent
/// its inverse is infinite, and it refuses (and aborts at) directions beyond 1.8e18.
bool has_usable_inverse(const Affine& t) {
  constexpr double kMost = 1e17, kLeastVolume = 1e-5;
  if (!(std::abs(t.determinant()) > kLeastVolume * length(t.x_axis) * length(t.y_axis) * length(t.z_axis)))
    return false;
  for (const Vec3d& axis : {Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}})
    if (!(max_abs(t.inverse_vector(axis)) < kMost)) return false;
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

}  // namespace

Geometry::Geometry(std::vector<Mesh> meshes, std::vector<Instance> instances, uint64_t memory_limit,
                   std::shared_ptr<const Opacity> opacity)
    : opacity_(std::move(opacity)), memory_(memory_limit), device_(embree::make_device()) {
  embree::count_memory(device_.get(), memory_);
  clean(meshes, instances);
  std::vector<uint32_t> users(meshes.size(), 0);
  std::vector<Box> mesh_boxes(meshes.size());
  for (const Instance& instance : instances) ++users[instance.mesh];
  meshes_.resize(meshes.size());
  if (opacity_)
    for (const Instance& instance : instances)
      for (const uint32_t material : instance.materials)
        if (opacity_->may_be_transparent(material)) meshes_[instance.mesh].may_be_transparent = true;
  Box world;
  for (size_t i = 0; i < meshes.size(); ++i) mesh_boxes[i] = bounds_of(meshes[i].positions);
  for (const Instance& instance : instances)
    world.include(transformed(mesh_boxes[instance.mesh], instance.world_from_object));
  if (!world.empty()) normalization_ = {world.centre(), unit_scale(world)};
  if (!is_finite(normalization_.centre) || !std::isfinite(normalization_.scale) || normalization_.scale == 0)
    throw std::invalid_argument("the scene's extent is not finite");

  scene_.reset(rtcNewScene(device_.get()));
  rtcSetSceneFlags(scene_.get(), RTC_SCENE_FLAG_ROBUST);
  for (size_t i = 0; i < meshes.size(); ++i) {
    if (users[i] == 0) continue;
    PlacedMesh& placed = meshes_[i];
    placed.triangles = std::move(meshes[i].triangles);
    placed.corner_normals = std::move(meshes[i].corner_normals);
    placed.material_slots = std::move(meshes[i].material_slots);
    placed.attributes = std::move(meshes[i].attributes);
    if (users[i] < 2) continue;  // placed with its one instance below
    const double scale = unit_scale(mesh_boxes[i]);
    const Vec3d centre = mesh_boxes[i].empty() ? Vec3d{} : mesh_boxes[i].centre();
    placed.positions =
        rounded(meshes[i].positions, {{scale, 0, 0}, {0, scale, 0}, {0, 0, scale}, -centre * scale});
    placed.scene.reset(rtcNewScene(device_.get()));
    rtcSetSceneFlags(placed.scene.get(), RTC_SCENE_FLAG_ROBUST);
    RTCGeometry geometry = make_triangles(placed);
    rtcAttachGeometry(placed.scene.get(), geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(placed.scene.get());
    check_build(meshes[i].name);
    has_shared_meshes_ = true;
  }

  LeftOut flat;
  for (Instance& instance : instances) {
    PlacedMesh& mesh = meshes_[instance.mesh];
    const Mesh& source = meshes[instance.mesh];
    const Box& box = mesh_boxes[instance.mesh];
    PlacedInstance placed{.name = std::move(instance.name),
                          .mesh = instance.mesh,
                          .render_from_mesh = {},
                          .render_from_object = normalization_.transform(instance.world_from_object),
                          .extent = 0,
                          .shared = users[instance.mesh] > 1,
                          .materials = std::move(instance.materials),
                          .receiver_set = instance.receiver_set};
    // A scale of zero leaves nothing to be seen, as in Cycles.
    const bool visible = !mesh.triangles.empty() && placed.render_from_object.determinant() != 0;
    const auto id = unsigned(instances_.size());
    RTCGeometry geometry = nullptr;
    if (visible && placed.shared) {
      geometry = make_instance(placed, mesh, box);
    } else if (visible) {
      mesh.positions = rounded(source.positions, placed.render_from_object);
      geometry = make_triangles(mesh);
    }
    if (!geometry && !mesh.triangles.empty()) flat.add(1, placed.name);
    if (geometry) {
      rtcSetGeometryMask(geometry, instance.rays);
      rtcCommitGeometry(geometry);
      rtcAttachGeometryByID(scene_.get(), geometry, id);
      rtcReleaseGeometry(geometry);
      check_build(placed.name);
      bounds_.include(transformed(box, placed.render_from_object));
      triangle_count_ += mesh.triangles.size();
    }
    instances_.push_back(std::move(placed));
  }
  flat.tell("objects whose scale is zero in some direction were", notes_);
  meshes.clear();  // the positions in double are not needed while Embree builds
  meshes.shrink_to_fit();
  rtcCommitScene(scene_.get());
  check_build("the whole scene");
}

/// Takes out what no ray needs, and notes it.
void Geometry::clean(std::vector<Mesh>& meshes, const std::vector<Instance>& instances) {
  LeftOut without_area, copies;
  std::vector<bool> used(meshes.size(), false);
  for (const Instance& instance : instances) used[instance.mesh] = true;
  for (size_t i = 0; i < meshes.size(); ++i) {
    if (!used[i]) continue;
    const UselessTriangles found = remove_useless_triangles(meshes[i]);
    without_area.add(found.without_area, meshes[i].name);
    copies.add(found.copies, meshes[i].name);
  }
  without_area.tell("triangles without area were", notes_);
  copies.tell("triangles that are copies of others were", notes_);
}

void Geometry::check_build(const std::string& what) const {
  if (memory_.exceeded())
    throw MemoryLimitReached(memory_.limit(), "building the ray tracing structure of " + what);
  embree::check_errors(device_.get(), what);
}

/// None if the transform has no usable inverse.
RTCGeometry Geometry::make_instance(PlacedInstance& placed, const PlacedMesh& mesh, const Box& box) const {
  const double scale = unit_scale(box);
  placed.render_from_mesh = placed.render_from_object *
                            Affine{{1 / scale, 0, 0}, {0, 1 / scale, 0}, {0, 0, 1 / scale}, box.centre()};
  if (!has_usable_inverse(placed.render_from_mesh)) return nullptr;
  placed.extent = max_abs(transformed(box, placed.render_from_object).extent());
  RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_INSTANCE);
  rtcSetGeometryInstancedScene(geometry, mesh.scene.get());
  const Affine& t = placed.render_from_mesh;
  const float columns[12] = {float(t.x_axis.x), float(t.x_axis.y), float(t.x_axis.z), float(t.y_axis.x),
                             float(t.y_axis.y), float(t.y_axis.z), float(t.z_axis.x), float(t.z_axis.y),
                             float(t.z_axis.z), float(t.origin.x), float(t.origin.y), float(t.origin.z)};
  rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, columns);
  return geometry;
}

RTCGeometry Geometry::make_triangles(const PlacedMesh& mesh) const {
  RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, mesh.positions.data(), 0,
                             sizeof(Vec3f), mesh.positions.size() - 1);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh.triangles.data(), 0,
                             3 * sizeof(uint32_t), mesh.triangles.size());
  if (mesh.may_be_transparent) {
    rtcSetGeometryUserData(geometry, const_cast<Geometry*>(this));  // read only
    rtcSetGeometryOccludedFilterFunction(geometry, filter_shadow_rays);
  }
  rtcSetGeometryMask(geometry, kAnyRay);  // Embree 4's default is a bit
  rtcCommitGeometry(geometry);
  return geometry;
}

}  // namespace penumbra
