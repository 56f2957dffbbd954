// SPDX-License-Identifier: GPL-3.0-or-later
// The path of a primary ray: the surface points that a pixel sees, directly and in mirrors.
#pragma once

#include <vector>

#include "lighting/lighting.h"
#include "render/settings.h"
#include "scene/scene.h"

namespace penumbra {

struct PathEnd {
  Vec3d background;                     // what is seen where the path leaves the scene
  double alpha = 0;                     // 0 where the primary ray meets nothing and the film is transparent
  bool hit = false;                     // the primary ray met something,
  SurfacePoint first;                   // here
  const std::string* object = nullptr;  // and on this object
};

class PathTracer {
 public:
  PathTracer(const Scene& scene, const Geometry& geometry, const RenderSettings& settings)
      : scene_(scene), geometry_(geometry), depth_(scene.has_mirrors() ? settings.mirror_depth : 0) {}

  /// Most surface points on a path.
  uint32_t length() const { return depth_ + 1; }

  /// Appends the path's surface points. stream: number of the path among the frame's; pixel: in the block.
  /// mirror_rays is increased by the rays traced.
  PathEnd follow(Ray ray, Hit hit, uint32_t pixel, uint64_t stream, std::vector<LitPoint>& points,
                 uint64_t& mirror_rays) const;

 private:
  const Scene& scene_;
  const Geometry& geometry_;
  uint32_t depth_;
};

}  // namespace penumbra
