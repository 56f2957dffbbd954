// SPDX-License-Identifier: GPL-3.0-or-later
// The path of a primary ray: the surface points that a pixel sees, directly, in mirrors and through surfaces.
#pragma once

#include <vector>

#include "lighting/lighting.h"
#include "material/evaluate.h"
#include "render/path_record.h"
#include "render/settings.h"

namespace penumbra {

/// What a primary ray sees, for data passes and edges: it is kept for every pixel, so no more than that.
struct FirstSight {
  // Of the surface, as in SurfacePoint; nothing without a hit:
  Vec3d position;
  double t;  // along the primary ray
  Vec3f geometric_normal, normal;
  const std::string* object = nullptr;  // or, without a hit, the first hole
  uint64_t lights = 0;  // which luminaires were seen themselves, in mirrors too: a bit of each
  bool hit = false;
};

struct PathEnd {
  Vec3d background;  // light that is there without luminaires: the world's, emission
  double alpha = 0;  // 0 where the primary ray meets nothing and the film is transparent
  FirstSight first;
};

class PathTracer {
 public:
  PathTracer(const Scene& scene, const Geometry& geometry, const Materials& materials,
             const RenderSettings& settings);

  /// Most surface points on a path.
  uint32_t length() const { return length_; }

  /// Those that the camera or mirrors see themselves.
  const std::vector<Luminaire>& seen_themselves() const { return seen_; }

  /// Appends the surface points of the path of one of the rays found. stream: number of the path among the
  /// frame's; pixel: in the block. mirror_rays is increased by the rays traced. record: what passes want to
  /// know; null: nothing.
  void follow(const HitColumns& found, uint32_t ray, uint32_t pixel, uint64_t stream,
              std::vector<LitPoint>& points, uint64_t& mirror_rays, PathEnd& end,
              const PathRecord* record = nullptr) const;

  /// One camera ray tells what a pixel sees there without noise: it meets one surface of constant colours
  /// that only reflects light, in all directions alike, or the same background as all others.
  bool is_plain(const Hit& hit) const;
  /// Which luminaires a camera ray that meets this sees themselves, as in FirstSight::lights.
  uint64_t lights_seen(const Ray& ray, const Hit& hit) const;

 private:
  struct Part;
  void leave(const Part& part, PathEnd& end, const PathRecord* record) const;
  void see(const SurfacePoint& surface, const Hit& hit, double t, PathEnd& end) const;
  void see_luminaires(const Ray& ray, double t_far, bool blocked, const Vec3d& throughput, uint32_t mirrors,
                      PathEnd& end, const PathRecord* record) const;

  const Scene& scene_;
  const Geometry& geometry_;
  const Materials& materials_;
  std::vector<Luminaire> seen_;
  std::vector<uint8_t> ends_paths_;  // by material: it only reflects light of luminaires
  uint32_t mirror_depth_, length_;
  bool perspective_;
  double scale_;  // of the normalization
  double pixel_;  // width in the camera's window
};

}  // namespace penumbra
