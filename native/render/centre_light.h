// SPDX-License-Identifier: GPL-3.0-or-later
// Penumbra on smooth surfaces: where light varies slowly from pixel to pixel, the filtered pixel is the light
// at its centre, and one surface point serves all rays.
#pragma once

#include "lighting/bounded_refine.h"
#include "render/sample_packet.h"

namespace penumbra {

class CentreLight {
 public:
  CentreLight(const RenderContext& context, const Block& block, FilteredFrame& frame,
              const std::vector<FilteredPixel>& pixels, RenderTally& tally);

  /// Traces the centres of at most kPacket pixels, gives their uncertain slots the first 16 points each, and
  /// makes edges of those that see another surface there than their first samples did.
  void start(std::span<const uint32_t> pixels);

  /// Does the pixel's centre see part of this slot's luminaire?
  bool mixed(uint32_t pixel, uint32_t slot) const;

  /// Makes edges of those pixels of one tile (all its smooth ones) where light is not linear within the
  /// filter, as far as 16 points can tell; refines the others until they are within the tolerance; looks
  /// again.
  void refine(std::span<const uint32_t> pixels, const Rectangle& tile);

  const PixelLight& light(uint32_t pixel) const { return light_[pixel]; }

  /// Adds the light of a pixel's uncertain luminaires, told apart.
  void add_parts(uint32_t pixel, std::span<Vec3d> parts) const;

  /// What was decided about a smooth pixel's luminaires, for --debug-pixel.
  void tell(PixelTrace& trace) const;

 private:
  static constexpr uint32_t kNone = ~0u;
  uint32_t& item_of(uint32_t p, uint32_t pair) { return item_of_[size_t(p) * pairs_ + pair]; }
  uint32_t item_of(uint32_t p, uint32_t pair) const { return item_of_[size_t(p) * pairs_ + pair]; }
  bool uncertain(uint32_t p, uint32_t pair) const;
  void trace(std::span<const uint32_t> pixels);
  void add_items(uint32_t p);
  double value(uint32_t p, uint32_t pair) const;
  double filter_error(uint32_t p, uint32_t pair, const Rectangle& tile) const;
  std::vector<uint32_t> keep_smooth(std::span<const uint32_t> pixels, const Rectangle& tile, bool first);

  const RenderContext& c_;
  const Block& block_;
  FilteredFrame& frame_;
  const std::vector<FilteredPixel>& pixels_;
  RenderTally& tally_;
  BoundedSettings settings_;
  uint32_t luminaires_, lobes_, pairs_;  // pairs: of bounce and luminaire
  std::vector<LitPoint> points_;
  std::vector<uint32_t> first_point_, path_length_;  // by pixel
  std::vector<BoundedItem> items_;
  std::vector<uint32_t> item_of_;  // by pixel and pair
  std::vector<PixelLight> light_;  // by pixel
  ItemSampler sampler_;
};

}  // namespace penumbra
