// SPDX-License-Identifier: GPL-3.0-or-later
// Primary rays of a pixel's samples: places under its filter and on the lens, and times of the shutter.
#pragma once

#include "render/camera_rays.h"
#include "render/pixel_filter.h"
#include "sampling/pixel_light_sampler.h"

namespace penumbra {

class PixelRays {
 public:
  /// moves: the scene, or the camera.
  PixelRays(const CameraRays& camera, const PixelFilter& filter, const PixelLightSampler& sampler, bool moves)
      : camera_(camera), filter_(filter), sampler_(sampler), moves_(moves) {}

  /// More than the pixel filter spreads a pixel's rays: what one of them sees tells little of the others.
  bool spread() const { return camera_.has_lens() || moves_; }
  /// Of a sample, its place on a luminaire included.
  int dimensions() const { return 4 + (camera_.has_lens() ? 2 : 0) + (moves_ ? 1 : 0); }

  /// Rays of samples [first, first + count), count at most kPacket, of the pixel whose bottom left corner is
  /// (x, y) in the full frame and whose number there is `key`; their places dx, dy in pixels from its centre.
  void make(uint64_t key, uint32_t x, uint32_t y, uint32_t first, uint32_t count, Ray* rays, double* dx,
            double* dy) const;

 private:
  const CameraRays& camera_;
  const PixelFilter& filter_;
  const PixelLightSampler& sampler_;
  bool moves_;
};

}  // namespace penumbra
