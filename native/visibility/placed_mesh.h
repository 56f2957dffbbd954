// SPDX-License-Identifier: GPL-3.0-or-later
// A mesh as Embree sees it, and meshes that stay when their scene goes.
#pragma once

#include <memory>
#include <mutex>
#include <unordered_map>
#include <vector>

#include "scene/scene.h"
#include "visibility/embree.h"
#include "visibility/useless_triangles.h"

namespace penumbra {

/// Positions in render space for a mesh used once, else in a unit-size space of its own. Embree keeps
/// pointers into it: it never moves.
struct PlacedMesh {
  std::vector<Vec3f> positions;  // one more than there are vertices: Embree reads 16 bytes at a time
  std::vector<std::array<uint32_t, 3>> triangles;
  std::vector<Vec3f> corner_normals;  // in render space and unit for a mesh used once, else the object's
  std::vector<uint32_t> material_slots;
  std::vector<Attribute> attributes;
  embree::SceneHandle scene;  // only where it is placed by instances of it
  bool may_be_transparent = false;

  PlacedMesh() = default;
  PlacedMesh(const PlacedMesh&) = delete;
  PlacedMesh& operator=(const PlacedMesh&) = delete;

  /// Takes all of a mesh but its positions.
  void take(Mesh& mesh);
  /// Takes the positions of a mesh that is to be placed by instances: unit_from_object of its box, rounded.
  void take_unit_positions(const std::vector<Vec3d>& positions, const Box& box);
  /// An Embree geometry of its triangles, committed; the caller's to release.
  RTCGeometry make_triangles(RTCDevice device) const;
  /// Builds its own BVH. Throws as CountedDevice::check_build, and has none then.
  void build(embree::CountedDevice& device, const std::string& name);
};

Box bounds_of(const std::vector<Vec3d>& positions);

/// The power of two that brings a box's largest half extent into (1/2, 1]; 1 for a point or nothing.
double unit_scale(const Box& box);

/// Rounded to single precision, with one vertex more as padding.
std::vector<Vec3f> rounded(const std::vector<Vec3d>& positions, const Affine& transform);

/// A mesh with a BVH of its own, built when a scene first needs it and shared by all that have the mesh, one
/// after the other or at the same time.
class KeptMesh {
 public:
  /// mesh: checked as a scene does; hash: its.
  KeptMesh(Mesh mesh, uint64_t hash, std::shared_ptr<embree::CountedDevice> device);

  uint64_t hash() const { return hash_; }
  const std::string& name() const { return name_; }
  const Box& box() const { return box_; }
  const UselessTriangles& left_out() const { return left_out_; }
  const std::shared_ptr<embree::CountedDevice>& device() const { return device_; }
  /// Whether shadow rays may pass it is built in. Throws as PlacedMesh::build; the next call tries again.
  std::shared_ptr<const PlacedMesh> placed(bool may_be_transparent);

 private:
  std::shared_ptr<embree::CountedDevice> device_;
  std::string name_;
  uint64_t hash_;
  Box box_;
  UselessTriangles left_out_;
  std::mutex mutex_;
  Mesh source_;                            // until something is placed
  std::shared_ptr<PlacedMesh> placed_[2];  // by may_be_transparent
};

/// Finds kept meshes by their content. Holds none itself: a mesh goes with the last that uses it.
class MeshStore {
 public:
  /// The mesh of this content, kept from before or new.
  std::shared_ptr<KeptMesh> keep(Mesh mesh);

 private:
  std::shared_ptr<embree::CountedDevice> device_ = std::make_shared<embree::CountedDevice>();
  std::unordered_map<uint64_t, std::weak_ptr<KeptMesh>> meshes_;
};

}  // namespace penumbra
