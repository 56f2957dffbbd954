// SPDX-License-Identifier: GPL-3.0-or-later
// Light at the centres of pixels: where it varies slowly from one to the next, that is the filtered pixel's,
// and one surface point serves all rays. The first look, and penumbra on smooth surfaces; what the filter
// makes of it: centre_filter.cpp.
#pragma once

#include "lighting/bounded_refine.h"
#include "lighting/first_look.h"
#include "render/sample_packet.h"

namespace penumbra {

class FilteredParts;

/// Of a centred edge's tolerance, what is kept for the shares of surfaces, and so left for them, as both are
/// independent.
inline constexpr double kKeptForSights = 0.2, kLeftForSights = 0.6;

class CentreLight {
 public:
  CentreLight(const RenderContext& context, const Block& block, FilteredFrame& frame,
              std::vector<FilteredPixel>& pixels, RenderTally& tally, FilteredParts* parts);

  /// Traces the centres of at most kPacket pixels of the frame, those outside the block, too: what they see
  /// makes some of them plain.
  void look(std::span<const PixelPlace> places);
  /// What luminaires send there: of pixels so far, whole quads, as many as it pays for, or, after the last,
  /// of all.
  void look_at_lights(bool all_found);

  /// Traces the centres of at most kPacket pixels, gives their uncertain slots the first 16 points each, and
  /// makes edges of those that see another surface there than their first samples did.
  void start(std::span<const uint32_t> pixels);

  /// Does the pixel's centre see part of this slot's luminaire?
  bool mixed(uint32_t pixel, uint32_t slot) const;

  /// Makes edges of those pixels of one tile (all its smooth ones) where light is not linear within the
  /// filter, as far as 16 points can tell; refines the others until they are within the tolerance; looks
  /// again.
  void refine(std::span<const uint32_t> pixels, const Rectangle& tile);

  /// By how much light differs from the centre of a plain pixel to those of neighbours on the same surface at
  /// most, as far as it is known in its tile, display units; all of it, where nothing is.
  double slope(uint32_t pixel) const;

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
  void trace(std::span<const PixelPlace> places, Ray* rays, HitColumns& found) const;
  PathEnd follow(const HitColumns& found, uint32_t ray, uint32_t pixel, const PathRecord* record);
  void add_dropped_items();
  void trace_samples(std::span<const uint32_t> pixels);
  void add_items(uint32_t p);
  double value(uint32_t p, uint32_t pair) const;
  bool knows(uint32_t p, uint32_t pair) const;
  bool continues(uint32_t p, int axis) const;
  bool tells(uint32_t p, uint32_t pair) const;
  LobeLight light_of(uint32_t p, uint32_t pair) const;
  Vec3d filter_change(uint32_t p, uint32_t pair) const;
  bool may_be_filtered(uint32_t p) const;
  void set_filter(uint32_t p, const Rectangle& tile);
  double filter_error(uint32_t p, uint32_t pair, const Rectangle& tile, double noise) const;
  double noise_of(uint32_t p, uint32_t pair, bool first) const;
  std::vector<uint32_t> keep_smooth(std::span<const uint32_t> pixels, const Rectangle& tile, bool first);

  const RenderContext& c_;
  const Block& block_;
  FilteredFrame& frame_;
  std::vector<FilteredPixel>& pixels_;
  RenderTally& tally_;
  FilteredParts* parts_;  // null: nobody wants them
  BoundedSettings settings_;
  uint32_t luminaires_, lobes_, pairs_;  // pairs: of bounce and luminaire
  std::vector<LitPoint> points_;
  std::vector<uint32_t> first_point_, path_length_;  // by pixel
  std::vector<BoundedItem> items_;
  std::vector<uint32_t> item_of_;  // by pixel and pair
  std::vector<PixelLight> light_;  // by pixel
  std::vector<uint8_t> refined_;   // by pixel: its items are within the tolerance
  std::vector<uint8_t> axes_;      // by pixel: bits of those along which its neighbours count
  double weight_, kink_share_;     // of a neighbour; of an unfiltered kink's error, what is left
  ItemSampler sampler_;
  FirstLook first_look_;
};

}  // namespace penumbra
