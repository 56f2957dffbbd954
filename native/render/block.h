// SPDX-License-Identifier: GPL-3.0-or-later
// Where a sample becomes a pixel: a block of the frame from camera rays to the film.
#pragma once

#include <array>
#include <string>

#include "lighting/lighting.h"
#include "render/edge_map.h"
#include "render/extra_passes.h"
#include "render/film.h"
#include "render/paths.h"
#include "render/pixel_rays.h"

namespace penumbra {

/// Everything that is the same for all blocks that a thread renders.
struct RenderContext {
  const RenderSettings& settings;
  const Scene& scene;
  const Geometry& geometry;
  const CameraRays& camera;
  const PathTracer& paths;
  std::span<const Luminaire> luminaires;
  const Lighting& lighting;
  const Sampler& light_sampler;
  const PixelFilter& filter;
  const Sampler& pixel_sampler;
  const PixelLightSampler& pixel_light_sampler;
  const PixelRays& pixel_rays;
  const EdgeMap* edge_map;  // null: any pixel may show edges
  Film& film;
  const ExtraPasses& extras;
  BlockMemory& memory;  // the thread's
};

struct RenderTally {
  LightTally light;
  uint64_t primary_rays = 0, mirror_rays = 0;
  uint64_t pixels_at_limit = 0, non_finite_pixels = 0;
  std::string first_non_finite;  // which pixel, and the object seen there

  /// All numbers in a fixed order, for a checkpoint.
  using Counts = std::array<uint64_t, 9>;
  RenderTally() = default;
  RenderTally(const Counts& counts, std::string first_non_finite_pixel);
  Counts counts() const;
  RenderTally& operator+=(const RenderTally& o);
};

/// `core` with a halo, clipped to the frame; and the block that they make.
Rectangle with_halo(const Rectangle& core, uint32_t halo, const RenderSettings& settings);
Block block_of(const Rectangle& core, const Rectangle& area, const RenderSettings& settings);

/// A pixel of the full frame.
struct PixelPlace {
  uint32_t x, y;
};

/// Number of a pixel in a block of that area; kOutside if it lies there.
inline constexpr uint32_t kOutside = ~0u;
inline uint32_t pixel_at(const PixelPlace& place, const Rectangle& area) {
  const uint32_t x = place.x - area.x, y = place.y - area.y;  // wraps below the area
  return x < area.width && y < area.height ? y * area.width + x : kOutside;
}

/// Calls function with the places of kPacket pixels each, quads of 2 x 2 one after the other, that together
/// cover the area: whole tiles of the frame, so that packets are the same wherever a block begins.
template <typename Function>
void for_packets_of_pixels(const Rectangle& area, Function function) {
  constexpr uint32_t kSide = 4;
  static_assert(kSide * kSide == kPacket);
  PixelPlace places[kPacket];
  for (uint32_t y = area.y / kSide * kSide; y < area.y + area.height; y += kSide)
    for (uint32_t x = area.x / kSide * kSide; x < area.x + area.width; x += kSide) {
      for (uint32_t i = 0; i < kPacket; ++i)
        places[i] = {x + ((i & 1) | (i >> 1 & 2)), y + ((i >> 1 & 1) | (i >> 2 & 2))};
      function(std::span<const PixelPlace>(places));
    }
}

/// Tells a trace which pixel of the block, whose area in the frame is `area`, it is about.
void aim(PixelTrace& trace, const Rectangle& area);

/// "pixel X,Y (OBJECT)", for messages.
std::string pixel_name(uint32_t x, uint32_t y, const std::string* object);

/// Depth, normal and position of what a path met first.
void set_data_passes(PixelValues& values, const FirstSight& first, const Normalization& normalization);

/// Renders the pixels of `core` (full frame) and writes those that lie in the film's region.
void render_block(const RenderContext& context, const Rectangle& core, RenderTally& tally);

}  // namespace penumbra
