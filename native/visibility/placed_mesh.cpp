// SPDX-License-Identifier: GPL-3.0-or-later
#include "visibility/placed_mesh.h"

#include <algorithm>
#include <cmath>

#include "sampling/hash.h"
#include "visibility/geometry.h"

namespace penumbra {

namespace {

/// A bound of the strands' curves, by their Bezier points.
Box bounds_of_strands(const Mesh& mesh, const std::vector<Vec3d>& keys) {
  Box box;
  if (mesh.segments.empty())
    for (const Vec3d& p : keys) box.include(p);
  for (const uint32_t first : mesh.segments) {
    const Vec3d* p = &keys[first];
    for (const Vec3d& bound : {p[1], p[1] + (p[2] - p[0]) / 6.0, p[2] - (p[3] - p[1]) / 6.0, p[2]})
      box.include(bound);
  }
  if (box.empty()) return box;
  // Radii may overshoot between keys as positions do, by less than their largest difference.
  const double radius = 2 * double(*std::max_element(mesh.radii.begin(), mesh.radii.end()));
  const Vec3d margin{radius, radius, radius};
  box.include(box.low - margin);
  box.include(box.high + margin);
  return box;
}

Box bounds_of_positions(const Mesh& mesh, const std::vector<Vec3d>& positions) {
  if (mesh.strands != StrandShape::kNone) return bounds_of_strands(mesh, positions);
  Box box;
  for (const Vec3d& p : positions) box.include(p);
  return box;
}

/// Rounded to single precision, with one vertex more as padding.
std::vector<Vec3f> rounded(const std::vector<Vec3d>& positions, const Affine& transform) {
  std::vector<Vec3f> result;
  result.reserve(positions.size() + 1);
  for (const Vec3d& p : positions) result.emplace_back(transform.point(p));
  result.emplace_back();
  return result;
}

/// Embree aborts at curves so small that the inverse of their extent is infinite. Far below what can be seen.
constexpr double kLeastRadius = 1e-20;

/// Radii grow with the third root of the volume, as in Cycles.
std::vector<Key> rounded_keys(const std::vector<Vec3d>& positions, const std::vector<float>& radii,
                              const Affine& transform) {
  const double scale = std::cbrt(std::abs(transform.determinant()));
  std::vector<Key> result;
  result.reserve(positions.size());
  for (size_t i = 0; i < positions.size(); ++i) {
    const Vec3f p(transform.point(positions[i]));
    result.push_back({p.x, p.y, p.z, float(std::max(radii[i] * scale, kLeastRadius))});
  }
  return result;
}

}  // namespace

Box bounds_of(const Mesh& mesh) {
  Box box = bounds_of_positions(mesh, mesh.positions);
  for (const MeshPose& pose : mesh.motion) box.include(bounds_of_positions(mesh, pose.positions));
  return box;
}

double unit_scale(const Box& box) {
  const double half = box.empty() ? 0 : max_abs(box.extent()) / 2;
  if (half == 0) return 1;
  return std::exp2(-std::ceil(std::log2(half)));
}

Affine unit_from_object(const Box& box) {
  const double scale = unit_scale(box);
  const Vec3d centre = box.empty() ? Vec3d{} : box.centre();
  return {{scale, 0, 0}, {0, scale, 0}, {0, 0, scale}, -centre * scale};
}

size_t PlacedMesh::primitives() const {
  if (strands == StrandShape::kNone) return triangles.size();
  return strands == StrandShape::kSphere ? keys.front().size() : segments.size();
}

void PlacedMesh::take(Mesh& mesh) {
  triangles = std::move(mesh.triangles);
  corner_normals = std::move(mesh.corner_normals);
  normals_of_vertices = mesh.normals_of_vertices;
  material_slots = std::move(mesh.material_slots);
  attributes = std::move(mesh.attributes);
  strands = mesh.strands;
  segments = mesh.segments;
  if (!corner_normals.empty())
    for (MeshPose& pose : mesh.motion) normal_motion.push_back(std::move(pose.corner_normals));
}

void PlacedMesh::take_positions(const Mesh& mesh, const Affine& placed_from_object) {
  if (mesh.strands == StrandShape::kNone) {
    positions = rounded(mesh.positions, placed_from_object);
    for (const MeshPose& pose : mesh.motion)
      position_motion.push_back(rounded(pose.positions, placed_from_object));
    return;
  }
  if (mesh.motion.empty()) keys.push_back(rounded_keys(mesh.positions, mesh.radii, placed_from_object));
  for (const MeshPose& pose : mesh.motion)
    keys.push_back(rounded_keys(pose.positions, mesh.radii, placed_from_object));
}

StrandPlace PlacedMesh::strand_place(uint32_t primitive, double u, double time) const {
  // Weights of a Catmull-Rom segment's four keys, and of its derivative; a sphere has one key.
  const bool sphere = strands == StrandShape::kSphere;
  const double uu = u * u, uuu = uu * u;
  const double at[4] = {(-uuu + 2 * uu - u) / 2, (3 * uuu - 5 * uu + 2) / 2, (-3 * uuu + 4 * uu + u) / 2,
                        (uuu - uu) / 2};
  const double along[4] = {(-3 * uu + 4 * u - 1) / 2, (9 * uu - 10 * u) / 2, (-9 * uu + 8 * u + 1) / 2,
                           (3 * uu - 2 * u) / 2};
  StrandPlace place{};
  const auto add = [&](const std::vector<Key>& all, double share) {
    for (int i = 0; i < (sphere ? 1 : 4); ++i) {
      const Key& key = all[sphere ? primitive : segments[primitive] + uint32_t(i)];
      const Vec3d p{key.x, key.y, key.z};
      place.centre += p * (share * (sphere ? 1 : at[i]));
      place.radius += key.radius * share * (sphere ? 1 : at[i]);
      if (!sphere) place.tangent += p * (share * along[i]);
    }
  };
  if (keys.size() == 1) {
    add(keys.front(), 1);
  } else {
    const TimeSegment segment(time, keys.size());
    add(keys[segment.first], 1 - segment.share);
    add(keys[segment.first + 1], segment.share);
  }
  place.radius = std::max(place.radius, 0.0);
  if (sphere) place.tangent = {0, 0, place.radius};
  return place;
}

void PlacedMesh::split_long() {
  if (deforms() || may_be_transparent || strands != StrandShape::kNone) return;
  positions.pop_back();
  pieces = split_long_triangles(positions, triangles);
  positions.emplace_back();
}

void PlacedMesh::set_vertices(RTCGeometry geometry) const {
  const size_t times = std::max(position_motion.size(), keys.size());
  if (times > 1) rtcSetGeometryTimeStepCount(geometry, unsigned(times));
  if (strands != StrandShape::kNone) {
    for (size_t i = 0; i < keys.size(); ++i)
      rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, unsigned(i), RTC_FORMAT_FLOAT4,
                                 keys[i].data(), 0, sizeof(Key), keys[i].size());
    return;
  }
  for (size_t i = 0; i < std::max<size_t>(times, 1); ++i) {
    const std::vector<Vec3f>& at = position_motion.empty() ? positions : position_motion[i];
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, unsigned(i), RTC_FORMAT_FLOAT3, at.data(), 0,
                               sizeof(Vec3f), at.size() - 1);
  }
}

RTCGeometry PlacedMesh::make_geometry(RTCDevice device) const {
  constexpr RTCGeometryType kTypes[] = {RTC_GEOMETRY_TYPE_TRIANGLE, RTC_GEOMETRY_TYPE_FLAT_CATMULL_ROM_CURVE,
                                        RTC_GEOMETRY_TYPE_ROUND_CATMULL_ROM_CURVE,
                                        RTC_GEOMETRY_TYPE_SPHERE_POINT};
  constexpr float kRibbonPieces = 8;  // straight ones of each segment
  RTCGeometry geometry = rtcNewGeometry(device, kTypes[size_t(strands)]);
  set_vertices(geometry);
  const auto& corners = pieces.corners.empty() ? triangles : pieces.corners;
  if (strands == StrandShape::kNone)
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, corners.data(), 0,
                               3 * sizeof(uint32_t), corners.size());
  else if (strands != StrandShape::kSphere)
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, segments.data(), 0,
                               sizeof(uint32_t), segments.size());
  if (strands == StrandShape::kRibbon) rtcSetGeometryTessellationRate(geometry, kRibbonPieces);
  if (may_be_transparent) rtcSetGeometryOccludedFilterFunction(geometry, Geometry::filter_shadow_rays);
  rtcSetGeometryMask(geometry, kAnyRay);  // Embree 4's default is a bit
  rtcCommitGeometry(geometry);
  return geometry;
}

void PlacedMesh::build(embree::CountedDevice& device, const std::string& name) {
  embree::SceneHandle made(rtcNewScene(device.device.get()));
  rtcSetSceneFlags(made.get(), RTC_SCENE_FLAG_ROBUST);
  split_long();
  RTCGeometry geometry = make_geometry(device.device.get());
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
      box_(bounds_of(mesh)),
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
      made->normals_of_vertices = other->normals_of_vertices;
      made->material_slots = other->material_slots;
      made->attributes = other->attributes;
      made->position_motion = other->position_motion;
      made->normal_motion = other->normal_motion;
      made->strands = other->strands;
      made->keys = other->keys;
      made->segments = other->segments;
    } else {
      made->take_positions(source_, unit_from_object(box_));
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
