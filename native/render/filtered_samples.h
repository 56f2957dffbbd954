// SPDX-License-Identifier: GPL-3.0-or-later
// Traces samples of a block's filtered pixels, and adds what they find to the pixels' sums.
#pragma once

#include "render/filtered_parts.h"
#include "render/sample_packet.h"

namespace penumbra {

class FilteredSamples {
 public:
  FilteredSamples(const RenderContext& context, FilteredFrame& frame, std::vector<FilteredPixel>& pixels,
                  RenderTally& tally);

  /// Samples [first, first + count) of some pixels, as many pixels a packet as fit.
  void trace_each(std::span<const uint32_t> pixels, uint32_t first, uint32_t count);
  /// Their camera rays alone.
  void look_each(std::span<const uint32_t> pixels, uint32_t first, uint32_t count);
  /// The camera rays alone of plain pixels' first samples: whether they see the same as the centre, and
  /// whether the pixels stay plain.
  void look_around(std::span<const uint32_t> pixels);
  /// One value of each surface in at most four pixels that no sample of known value met.
  void probe_surfaces(std::span<const uint32_t> pixels);
  /// A plain pixel's centre is a value of the surface that it met.
  void add_centre(uint32_t p);
  /// All that the pixel's samples told, but what its camera rays met.
  void forget(uint32_t p);

  /// What passes want to know; null: nothing.
  FilteredParts* parts() { return parts_.get(); }

 private:
  std::span<Slot> slots(uint32_t p) { return frame_.of_pixel(p); }
  void add_light(std::span<const SampleRun> runs);
  void add_to(Slot& slot, const SlotColumns& column, uint32_t lane, uint32_t count) const;
  void note_visibility(uint32_t p, uint32_t lane);
  bool sees_more(FilteredPixel& pixel, uint32_t lane) const;
  void add_sight(FilteredPixel& pixel, uint32_t lane, uint32_t index) const;
  void add_value(SeenSurface& surface, uint32_t lane) const;
  void fit_plane(const SampleRun& run, uint32_t lane);

  const RenderContext& c_;
  FilteredFrame& frame_;
  std::vector<FilteredPixel>& pixels_;
  double display_scale_, tolerance_;
  SamplePacket packet_;
  std::unique_ptr<FilteredParts> parts_;
};

}  // namespace penumbra
