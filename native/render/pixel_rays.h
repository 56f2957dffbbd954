// SPDX-License-Identifier: GPL-3.0-or-later
// Primary rays of a pixel's samples: places under its filter and on the lens, and times of the shutter.
#pragma once

#include "render/camera_rays.h"
#include "render/pixel_filter.h"
#include "sampling/pixel_light_sampler.h"

namespace penumbra {

/// Samples of the pixel whose bottom left corner is (x, y) in the full frame; their key is its number there.
struct PixelSamples {
  uint32_t x, y;
  SampleRange range;
};

class PixelRays {
 public:
  /// moves: the scene, or the camera.
  PixelRays(const CameraRays& camera, const PixelFilter& filter, const PixelLightSampler& sampler, bool moves)
      : camera_(camera), filter_(filter), sampler_(sampler), moves_(moves) {}

  /// More than the pixel filter spreads a pixel's rays: what one of them sees tells little of the others.
  bool spread() const { return camera_.has_lens() || moves_; }
  /// Of a sample, its place on a luminaire included.
  int dimensions() const { return 2 + kLightDimensions + (camera_.has_lens() ? 2 : 0) + (moves_ ? 1 : 0); }

  /// Rays of at most kPacket samples, pixel after pixel; their places dx, dy in pixels from its centre.
  void make(std::span<const PixelSamples> pixels, Ray* rays, double* dx, double* dy) const;

 private:
  const CameraRays& camera_;
  const PixelFilter& filter_;
  const PixelLightSampler& sampler_;
  bool moves_;
};

}  // namespace penumbra
