// SPDX-License-Identifier: GPL-3.0-or-later
// Where a sample becomes a pixel: 8x8 pixels from camera rays to the film.
#pragma once

#include <string>
#include <vector>

#include "lighting/direct_light.h"
#include "render/camera_rays.h"
#include "render/film.h"

namespace penumbra {

/// Side of a tile in pixels. Tiles are aligned to the full frame, not to the region, and are traced whole, so
/// that a pixel does not depend on where a border cuts.
inline constexpr uint32_t kTile = 8;

/// Everything that is the same for all tiles of a render.
struct TileContext {
  const RenderSettings& settings;
  const Scene& scene;
  const Geometry& geometry;
  const CameraRays& camera;
  const DirectLight& light;
  const PixelFilter& filter;
  const Sampler& pixel_sampler;
  Film& film;
};

struct TileTally {
  LightTally light;
  uint64_t primary_rays = 0, mirror_rays = 0;
  uint64_t pixels_at_limit = 0, non_finite_pixels = 0;
  std::string first_non_finite;  // which pixel, and the object seen there
};

/// Renders the tile whose lower left pixel is (x, y), both multiples of kTile.
void render_tile(const TileContext& context, uint32_t x, uint32_t y, TileTally& tally);

}  // namespace penumbra
