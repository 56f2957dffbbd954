// SPDX-License-Identifier: GPL-3.0-or-later
// Which triangles may hide a luminaire from a point? A BVH that is asked by shafts instead of rays.
#pragma once

#include <optional>
#include <vector>

#include "math/parallelogram.h"
#include "scene/surface_point.h"
#include "visibility/embree.h"

namespace penumbra {

struct PlacedMesh;

/// A parallelogram as shadow rays from a surface point see it; render space, rounded as they are.
struct LuminaireView {
  Vec3f origin;                  // of the rays
  Vec3f corner, edge_u, edge_v;  // from there
  Vec3f normal;                  // of the surface, as it is shaded
  /// Its chords run along edge_u + skew edge_v. A chord's number is tau = t - skew s, from -skew to 1.
  float skew;

  /// The skew, for `direction` in 0 ... 1: far from the luminaire's own edges, which those of what people
  /// build are often parallel to. None where rays to a part of it start on the other side of the surface, or
  /// beyond single precision.
  static std::optional<LuminaireView> from(const SurfacePoint& surface, const Parallelogram& luminaire,
                                           float direction);
};

/// What a triangle hides of a parallelogram: on chord tau, all s where constant + slope tau + speed s >= 0
/// for each of four functions, one for each of its edges and one for the end of the rays.
struct Occluder {
  float constant[4], slope[4];
  float inverse[4];  // -1 / speed: times the value at s = 0, where the function is 0
  float lower[4];    // how far to move that for a bound from below, out of the way if it is one from above
  float upper[4];    // and the other way round
  float first_tau, end_tau;  // other chords are not met
};

/// Still, opaque triangles. Immutable.
class OccluderTree {
 public:
  /// Of meshes whose positions are in render space. Throws as CountedDevice::check_build.
  OccluderTree(embree::CountedDevice& device, const std::vector<const PlacedMesh*>& meshes);

  /// All triangles that may hide a part of the view's parallelogram above the horizon, each once, in an order
  /// that depends on the tree alone; false if there are more than `most`.
  bool find(const LuminaireView& view, uint32_t most, std::vector<Occluder>& out) const;

 private:
  struct ReleaseBvh {
    void operator()(RTCBVH bvh) const { rtcReleaseBVH(bvh); }
  };
  std::unique_ptr<std::remove_pointer_t<RTCBVH>, ReleaseBvh> bvh_;
  uintptr_t root_ = 0;
};

}  // namespace penumbra
