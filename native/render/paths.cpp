// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/paths.h"

namespace penumbra {

PathEnd PathTracer::follow(Ray ray, Hit hit, uint32_t pixel, uint64_t stream, std::vector<LitPoint>& points,
                           uint64_t& mirror_rays) const {
  PathEnd end;
  const Background& background = scene_.background();
  end.hit = hit.found();
  if (!end.hit) {
    if (!background.transparent) {
      if (background.seen_by_camera) end.background = background.radiance(ray.direction);
      end.alpha = 1;
    }
    return end;
  }
  end.alpha = 1;
  end.object = &geometry_.name_of(hit);
  Vec3d throughput{1, 1, 1};
  for (uint32_t bounce = 0;; ++bounce) {
    const SurfacePoint surface = geometry_.surface_point(ray, hit);
    const Material& material = scene_.materials()[surface.material];
    points.push_back(
        {surface, ray.direction, &material, throughput, stream * length() + bounce, pixel, bounce});
    if (bounce == 0) end.first = surface;

    throughput = throughput * material.mirror;
    if (bounce == depth_ || max_component(throughput) == 0) return end;
    ray = {surface.position + surface.geometric_normal * surface.rounding,
           normalize(reflect(ray.direction, surface.normal)), 0, 1e30};
    geometry_.intersect(&ray, 1, &hit);
    ++mirror_rays;
    if (!hit.found()) {
      end.background = throughput * background.radiance(ray.direction);
      return end;
    }
  }
}

}  // namespace penumbra
