// SPDX-License-Identifier: GPL-3.0-or-later
#include "visibility/placed_mesh.h"

#include <cmath>

#include "sampling/hash.h"
#include "visibility/geometry.h"

namespace penumbra {

Box bounds_of(const std::vector<Vec3d>& positions) {
  Box box;
  for (const Vec3d& p : positions) box.include(p);
  return box;
}

double unit_scale(const Box& box) {
  const double half = box.empty() ? 0 : max_abs(box.extent()) / 2;
  if (half == 0) return 1;
  return std::exp2(-std::ceil(std::log2(half)));
}

std::vector<Vec3f> rounded(const std::vector<Vec3d>& positions, const Affine& transform) {
  std::vector<Vec3f> result;
  result.reserve(positions.size() + 1);
  for (const Vec3d& p : positions) result.emplace_back(transform.point(p));
  result.emplace_back();
  return result;
}

void PlacedMesh::take(Mesh& mesh) {
  triangles = std::move(mesh.triangles);
  corner_normals = std::move(mesh.corner_normals);
  material_slots = std::move(mesh.material_slots);
  attributes = std::move(mesh.attributes);
}

void PlacedMesh::take_unit_positions(const std::vector<Vec3d>& source, const Box& box) {
  const double scale = unit_scale(box);
  const Vec3d centre = box.empty() ? Vec3d{} : box.centre();
  positions = rounded(source, {{scale, 0, 0}, {0, scale, 0}, {0, 0, scale}, -centre * scale});
}

RTCGeometry PlacedMesh::make_triangles(RTCDevice device) const {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, positions.data(), 0,
                             sizeof(Vec3f), positions.size() - 1);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, triangles.data(), 0,
                             3 * sizeof(uint32_t), triangles.size());
  if (may_be_transparent) rtcSetGeometryOccludedFilterFunction(geometry, Geometry::filter_shadow_rays);
  rtcSetGeometryMask(geometry, kAnyRay);  // Embree 4's default is a bit
  rtcCommitGeometry(geometry);
  return geometry;
}

void PlacedMesh::build(embree::CountedDevice& device, const std::string& name) {
  embree::SceneHandle made(rtcNewScene(device.device.get()));
  rtcSetSceneFlags(made.get(), RTC_SCENE_FLAG_ROBUST);
  RTCGeometry geometry = make_triangles(device.device.get());
  rtcAttachGeometry(made.get(), geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(made.get());
  device.check_build(name);
  scene = std::move(made);
}

KeptMesh::KeptMesh(Mesh mesh, uint64_t hash, std::shared_ptr<embree::CountedDevice> device)
    : device_(std::move(device)),
      name_(mesh.name),
      hash_(hash),
      box_(bounds_of(mesh.positions)),
      left_out_(remove_useless_triangles(mesh)),
      source_(std::move(mesh)) {}

std::shared_ptr<const PlacedMesh> KeptMesh::placed(bool may_be_transparent) {
  const std::lock_guard lock(mutex_);
  std::shared_ptr<PlacedMesh>& wanted = placed_[may_be_transparent];
  if (!wanted) {
    auto made = std::make_shared<PlacedMesh>();
    made->may_be_transparent = may_be_transparent;
    if (const PlacedMesh* other = placed_[!may_be_transparent].get()) {
      made->positions = other->positions;
      made->triangles = other->triangles;
      made->corner_normals = other->corner_normals;
      made->material_slots = other->material_slots;
      made->attributes = other->attributes;
    } else {
      made->take_unit_positions(source_.positions, box_);
      made->take(source_);
      source_ = {};
    }
    wanted = std::move(made);
  }
  if (!wanted->scene) wanted->build(*device_, name_);
  return wanted;
}

std::shared_ptr<KeptMesh> MeshStore::keep(Mesh mesh) {
  std::erase_if(meshes_, [](const auto& entry) { return entry.second.expired(); });
  const uint64_t hash = hash_of(mesh);
  std::weak_ptr<KeptMesh>& found = meshes_[hash];
  if (std::shared_ptr<KeptMesh> kept = found.lock()) return kept;
  auto kept = std::make_shared<KeptMesh>(std::move(mesh), hash, device_);
  found = kept;
  return kept;
}

}  // namespace penumbra
