// SPDX-License-Identifier: GPL-3.0-or-later
// A mesh as Embree sees it, and meshes that stay when their scene goes.
#pragma once

#include <memory>
#include <mutex>
#include <unordered_map>
#include <vector>

#include "scene/scene.h"
#include "visibility/embree.h"
#include "visibility/long_triangles.h"
#include "visibility/useless_triangles.h"

namespace penumbra {

/// A key of a strand, or a sphere: what Embree reads.
struct Key {
  float x, y, z, radius;
};

struct StrandPlace {
  Vec3d centre, tangent;  // on the strand's axis
  double radius;
};

/// Positions in render space for a mesh used once, else in a unit-size space of its own. Embree keeps
/// pointers into it: it never moves.
struct PlacedMesh {
  std::vector<Vec3f> positions;  // one more than there are vertices: Embree reads 16 bytes at a time
  std::vector<std::vector<Vec3f>> position_motion, normal_motion;  // see Mesh::motion
  StrandShape strands = StrandShape::kNone;
  std::vector<std::vector<Key>> keys;  // of strands in place of positions: at each time, or once
  std::vector<uint32_t> segments;
  std::vector<std::array<uint32_t, 3>> triangles;
  TrianglePieces pieces;              // that Embree has in place of the triangles, if there are any
  std::vector<Vec3f> corner_normals;  // in render space and unit for a mesh used once, else the object's
  bool normals_of_vertices = false;   // one a vertex, not three a triangle
  std::vector<uint32_t> material_slots;
  std::vector<Attribute> attributes;
  embree::SceneHandle scene;  // only where it is placed by instances of it
  bool may_be_transparent = false;

  PlacedMesh() = default;
  PlacedMesh(const PlacedMesh&) = delete;
  PlacedMesh& operator=(const PlacedMesh&) = delete;

  size_t primitives() const;
  bool deforms() const { return !position_motion.empty() || keys.size() > 1; }
  Vec3d position(uint32_t vertex, double time) const {
    return position_motion.empty() ? Vec3d(positions[vertex]) : moving(position_motion, vertex, time);
  }
  Vec3d corner_normal(uint32_t triangle, uint32_t corner, double time) const {
    const size_t i = normals_of_vertices ? triangles[triangle][corner] : 3 * size_t(triangle) + corner;
    return normal_motion.empty() ? Vec3d(corner_normals[i]) : moving(normal_motion, i, time);
  }
  /// Of a strand's segment at u in 0 ... 1, or of a sphere.
  StrandPlace strand_place(uint32_t primitive, double u, double time) const;

  /// Takes all of a mesh but its positions.
  void take(Mesh& mesh);
  /// Takes its positions, at all times, transformed and rounded.
  void take_positions(const Mesh& mesh, const Affine& placed_from_object);
  /// Cuts long triangles for Embree, if they stand still and nothing shines through them: where two pieces
  /// meet, a ray may meet both.
  void split_long();
  /// The triangle that one of Embree's is a piece of.
  uint32_t whole(uint32_t primitive) const {
    return pieces.whole.empty() ? primitive : pieces.whole[primitive];
  }
  /// An Embree geometry of its triangles or strands, committed; the caller's to release.
  RTCGeometry make_geometry(RTCDevice device) const;
  /// Builds its own BVH. Throws as CountedDevice::check_build, and has none then.
  void build(embree::CountedDevice& device, const std::string& name);

 private:
  static Vec3d moving(const std::vector<std::vector<Vec3f>>& motion, size_t i, double time) {
    const TimeSegment at(time, motion.size());
    return mixed(Vec3d(motion[at.first][i]), Vec3d(motion[at.first + 1][i]), at.share);
  }
  void set_vertices(RTCGeometry geometry) const;
};

/// Of a mesh at all times.
Box bounds_of(const Mesh& mesh);

/// unit_from_object of a mesh that is placed by instances, by its box.
Affine unit_from_object(const Box& box);

/// The power of two that brings a box's largest half extent into (1/2, 1]; 1 for a point or nothing.
double unit_scale(const Box& box);

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
