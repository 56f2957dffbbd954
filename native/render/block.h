// SPDX-License-Identifier: GPL-3.0-or-later
// Where a sample becomes a pixel: a block of the frame from camera rays to the film.
#pragma once

#include <string>

#include "lighting/lighting.h"
#include "render/camera_rays.h"
#include "render/film.h"
#include "render/paths.h"

namespace penumbra {

/// Side of a tile in pixels. Where neighbours matter, blocks are made of whole tiles of the full frame, so
/// that a pixel does not depend on where a border cuts.
inline constexpr uint32_t kTile = 8;

/// Everything that is the same for all blocks of a render.
struct RenderContext {
  const RenderSettings& settings;
  const Scene& scene;
  const Geometry& geometry;
  const CameraRays& camera;
  const PathTracer& paths;
  const Lighting& lighting;
  const PixelFilter& filter;
  const Sampler& pixel_sampler;
  Film& film;
};

struct RenderTally {
  LightTally light;
  uint64_t primary_rays = 0, mirror_rays = 0;
  uint64_t pixels_at_limit = 0, non_finite_pixels = 0;
  std::string first_non_finite;  // which pixel, and the object seen there
};

/// Depth, normal and position of what a path met first.
void set_data_passes(PixelValues& values, const PathEnd& end, const Normalization& normalization);

/// Renders the pixels of `core` (full frame) and writes those that lie in the film's region.
void render_block(const RenderContext& context, const Rectangle& core, RenderTally& tally);

}  // namespace penumbra
