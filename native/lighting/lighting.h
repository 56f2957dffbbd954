// SPDX-License-Identifier: GPL-3.0-or-later
// From surface points to light: what every way of lighting takes and gives.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "lighting/block_memory.h"
#include "lighting/pixel_trace.h"
#include "luminaire/luminaire.h"
#include "material/shading_point.h"
#include "sampling/sampler.h"
#include "visibility/geometry.h"

namespace penumbra {

class LightParts;

/// Side of a tile in pixels. Where neighbours matter, blocks are made of whole tiles of the full frame, so
/// that a pixel does not depend on where a border cuts.
inline constexpr uint32_t kTile = 8;

/// A surface point that a pixel sees, directly or in mirrors.
struct LitPoint {
  LitPoint() {}  // without zeroing what its maker writes
  SurfacePoint surface;
  Vec3d ray_direction;  // of the ray that found it
  const Closures* material;
  Vec3d throughput;                           // of the mirrors before it
  uint64_t stream;                            // its number among the frame's surface points
  uint32_t pixel;                             // x + y * width in the block
  uint32_t bounce;                            // points of the path before it
  bool mirrored;                              // seen in mirrors
  std::shared_ptr<const Closures> evaluated;  // where `material` varies over the surface; else null
};

/// A rectangle of pixels: the core, which gets its final values, and pixels around it that are only looked
/// at.
struct Block {
  uint32_t width, height;                            // with the halo
  uint32_t core_x, core_y, core_width, core_height;  // in the block

  uint32_t pixels() const { return width * height; }
  /// A pixel of the block lies so far from the core at most.
  bool in_core(uint32_t pixel, int margin) const {
    const int x = int(pixel % width) - int(core_x), y = int(pixel / width) - int(core_y);
    return x >= -margin && y >= -margin && x < int(core_width) + margin && y < int(core_height) + margin;
  }
};

/// Light that a pixel gets.
struct PixelLight {
  Vec3d radiance;
  double error = 0;  // display units
  uint64_t points = 0;
  bool at_limit = false;   // some luminaire used max_light_samples without satisfying its rule
  double noise_share = 1;  // of its points' standard error, where neighbours' points count, too
};

/// Thrown out of a block whose render was cancelled: nothing of it reaches the film.
struct Cancelled {};

/// What lighting did, in numbers.
struct LightTally {
  uint64_t light_points = 0;             // used in an estimate
  uint64_t shadow_rays = 0;              // traced, those beyond the stop included
  uint64_t shadow_rays_beyond_stop = 0;  // traced with a packet whose earlier points were enough
  uint64_t light_lines = 0;              // across luminaires, instead of points
  uint64_t decided_without_ray = 0;      // pairs of surface point and luminaire
  PixelTrace* trace = nullptr;           // told of one pixel, if there is one
  /// Set by whoever no longer wants the picture.
  const std::atomic<bool>* cancelled = nullptr;

  /// Called once a packet of rays or so, by every loop that an extreme setting makes long.
  void stop_if_cancelled() const {
    if (cancelled && cancelled->load(std::memory_order_relaxed)) throw Cancelled{};
  }

  LightTally& operator+=(const LightTally& o) {
    light_points += o.light_points;
    shadow_rays += o.shadow_rays;
    shadow_rays_beyond_stop += o.shadow_rays_beyond_stop;
    light_lines += o.light_lines;
    decided_without_ray += o.decided_without_ray;
    return *this;
  }
};

/// A block that is being lit.
struct LitBlock {
  const Block& block;
  std::span<const Luminaire> luminaires;
  const std::vector<LitPoint>& points;  // found so far
  std::vector<PixelLight>& out;         // of all points, block.pixels() elements
  LightTally& tally;
  LightParts* parts;    // where light is told apart, too; null: nowhere
  BlockMemory& memory;  // the thread's
};

/// Direct light of a block's points from its luminaires, added up for each pixel.
class BlockLighting {
 public:
  virtual ~BlockLighting() = default;

  /// More points were found, all of some 2 x 2 quads of the frame's pixels: what can be done as long as they
  /// are in the cache.
  virtual void look() = 0;
  /// All were.
  virtual void finish() = 0;
};

/// A way of lighting. Immutable, so that threads share it.
class Lighting {
 public:
  virtual ~Lighting() = default;

  /// Side of the largest blocks it wants, a multiple of kTile, and the pixels beyond that it looks at.
  virtual uint32_t block_side() const = 0;
  virtual uint32_t halo() const = 0;

  virtual std::unique_ptr<BlockLighting> begin(const LitBlock& block) const = 0;
};

}  // namespace penumbra
