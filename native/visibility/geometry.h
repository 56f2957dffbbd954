// SPDX-License-Identifier: GPL-3.0-or-later
// The scene's surfaces, placed for tracing: recentred and rescaled to about unit size, in Embree's BVH.
#pragma once

#include <memory>
#include <mutex>
#include <vector>

#include "scene/memory_limit.h"
#include "scene/normalization.h"
#include "scene/opacity.h"
#include "scene/scene.h"
#include "scene/surface_point.h"
#include "visibility/embree.h"
#include "visibility/hit_columns.h"
#include "visibility/placed_mesh.h"

namespace penumbra {

class OccluderTree;

/// Which triangle a ray meets, and no more.
struct Primitive {
  uint32_t instance = Hit::kNone, triangle = Hit::kNone;

  Primitive() {}
  Primitive(const Hit& hit) : instance(hit.instance), triangle(hit.triangle) {}
  friend bool operator==(const Primitive&, const Primitive&) = default;
};

/// A triangle, as far as it tells surfaces apart. In the space of the mesh, in the middle of the shutter's
/// time; strands have no normal.
struct Facet {
  Primitive primitive;
  uint32_t material = 0;
  Vec3d normal, corner;  // of any length
  bool flat = false;     // shaded by this normal
  bool strand = false;   // of hair: round
};

/// Do they belong to one surface that is smooth there: light on it may be much the same?
bool same_surface(const Facet& a, const Facet& b);
/// Sine of the angle between flat ones; 0 where shading is smooth, 1 between strands.
double step_between(const Facet& a, const Facet& b);

/// What a scene's triangles are to rays. Immutable, so that threads and renders can share it.
class Geometry {
 public:
  /// Builds the BVH. Throws std::runtime_error or std::bad_alloc where Embree fails, MemoryLimitReached where
  /// it wants more bytes than the limit (0: none), and std::invalid_argument for a scene beyond double
  /// precision. opacity: where given, shadow rays pass surfaces of materials that may be transparent.
  Geometry(std::vector<Mesh> meshes, std::vector<Instance> instances, uint64_t memory_limit = 0,
           std::shared_ptr<const Opacity> opacity = nullptr);
  ~Geometry();

  const Normalization& normalization() const { return normalization_; }
  RTCScene embree_scene() const { return scene_.get(); }
  /// Some mesh is used by more than one instance, or kept; Embree's coherent 16-wide traversal must then be
  /// avoided (Debian 12's Embree 3.13.5 hangs in it).
  bool has_shared_meshes() const { return has_shared_meshes_; }
  /// Whether packets of shadow rays from one point are traced by coherent traversal. It is half as fast again
  /// among a million leaves, a tenth among four objects of 12,000 triangles, a fifth slower over two
  /// triangles (tests/benchmarks). It may ask more than once of the same transparent surface, whose colour
  /// would then count twice (tests/python/test_coherent_shadows.py).
  bool has_coherent_shadows() const {
    return !has_shared_meshes_ && !has_transparency() && triangle_count_ >= 10'000;
  }
  bool has_transparency() const { return opacity_ != nullptr; }
  /// For chords of luminaires whose shadow rays have the mask kShadowRay, built when it is first asked for;
  /// null unless all there is are still, opaque triangles that are in the way of such rays, each mesh used
  /// once. Nor is there one under a memory limit: whether it is there must not depend on what else is.
  const OccluderTree* occluders() const;
  /// Something is elsewhere at another time.
  bool moves() const { return moves_; }

  /// First hits of up to 16 rays; bit i of `active` says whether ray i counts.
  void intersect(const Ray* rays, uint32_t active, Hit* hits) const;

  /// First hits of up to kPacket rays, and positions and normals there, recomputed in double from the
  /// vertices. The columns are good as long as the rays are, and hold what surface_point() wants to know of
  /// a ray whose hit was found.
  void find_surfaces(const Ray* rays, uint32_t count, HitColumns& out) const;
  void surface_point(const HitColumns& columns, uint32_t ray, SurfacePoint& out) const;
  void surface_point(const HitColumns& columns, uint32_t ray, PlacedPoint& out) const;
  /// Of one ray, whose hit is known.
  void surface_point(const Ray& ray, const Hit& hit, PlacedPoint& out) const;

  /// A point of a triangle, seen from the side of its normal or from behind; u, v: barycentric weights of its
  /// second and third corner. `t` is 1.
  PlacedPoint surface_point(const Hit& hit, double u, double v, bool from_behind) const;
  /// Of an instance, in the numbers that hits have; none if a scale of zero leaves nothing of it.
  uint32_t triangles_of(uint32_t instance) const;

  uint64_t triangles() const { return triangle_count_; }
  uint64_t instances() const { return instances_.size(); }
  uint64_t meshes() const { return meshes_.size(); }
  /// What of the scene was left out, in sentences that name the first object.
  const std::vector<std::string>& notes() const { return notes_; }
  const std::string& name_of(const Hit& hit) const { return instances_[hit.instance].name; }
  bool is_strand(const Hit& hit) const {
    return meshes_[instances_[hit.instance].mesh]->strands != StrandShape::kNone;
  }
  uint32_t material_of(const Hit& hit) const {
    const PlacedInstance& instance = instances_[hit.instance];
    return material_of(*meshes_[instance.mesh], instance, hit.triangle);
  }
  /// Some instance is of hair or points.
  bool has_strands() const { return has_strands_; }
  const PlacedMesh& mesh_of(uint32_t instance) const { return *meshes_[instances_[instance].mesh]; }
  /// From the space of the mesh's positions; null: they are in render space.
  const Affine* placing_of(uint32_t instance) const {
    return instances_[instance].shared ? &instances_[instance].render_from_mesh : nullptr;
  }
  /// Also of nothing.
  Facet facet_of(const Primitive& primitive) const;
  const ObjectTraits& traits_of(uint32_t instance) const { return instances_[instance].traits; }

  /// What Embree calls at surfaces that may be transparent; the context is an embree::ShadowContext.
  static void filter_shadow_rays(const RTCFilterFunctionNArguments* arguments);

 private:
  struct PlacedInstance {
    std::string name;
    uint32_t mesh;
    Affine render_from_mesh;    // from the space of PlacedMesh::positions
    Affine render_from_object;  // for normals
    double orientation = 1;     // -1 where the transform mirrors
    double extent;              // largest coordinate difference, render space; 0 unless the mesh is shared
    bool shared;                // the mesh has a BVH of its own, and this is an instance of that
    std::vector<uint32_t> materials;
    uint32_t receiver_set;
    ObjectTraits traits;
    std::vector<Affine> mesh_motion = {}, object_motion = {};  // of the two transforms
  };

  void clean(std::vector<Mesh>& meshes, const std::vector<uint32_t>& users);
  void note_what_rounding_loses(const std::vector<Instance>& instances, const std::vector<Box>& boxes);
  std::shared_ptr<const PlacedMesh> place_shared(Mesh& mesh, const Box& box, bool may_be_transparent) const;
  RTCGeometry make_instance(PlacedInstance& placed, const PlacedMesh& mesh, const Box& box) const;
  double transparency(const Ray& ray, const Hit& hit, uint8_t channel) const;
  struct Moved;
  static uint32_t material_of(const PlacedMesh& mesh, const PlacedInstance& instance, uint32_t triangle);
  /// What a place knows of the mesh and the instance that it is on.
  void set_owner(SurfacePlace& place, const PlacedMesh& mesh, const PlacedInstance& instance,
                 double time) const;
  void recompute(uint32_t count, HitColumns& columns) const;
  void set_normal(HitColumns& columns, uint32_t column) const;
  void strand_point(const Ray& ray, const Hit& hit, PlacedPoint& s) const;

  std::shared_ptr<const Opacity> opacity_;
  Normalization normalization_;
  Box bounds_;                                     // render space
  std::shared_ptr<embree::CountedDevice> device_;  // that of kept meshes, if there are any
  std::vector<std::shared_ptr<const PlacedMesh>> meshes_;
  std::vector<PlacedInstance> instances_;
  embree::SceneHandle scene_;
  bool has_shared_meshes_ = false, moves_ = false, has_strands_ = false, all_cast_shadows_ = true;
  mutable std::once_flag occluders_wanted_;
  mutable std::unique_ptr<const OccluderTree> occluders_;
  uint64_t triangle_count_ = 0;
  std::vector<std::string> notes_;
};

}  // namespace penumbra
