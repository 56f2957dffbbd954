// SPDX-License-Identifier: GPL-3.0-or-later
// What passes want to know of a block of filtered pixels; of the same samples and slots as Combined.
#pragma once

#include "render/centre_light.h"
#include "render/sample_packet.h"

namespace penumbra {

class FilteredParts {
 public:
  FilteredParts(const RenderContext& context, const FilteredFrame& frame, uint32_t pixels);

  /// Where the path of a plain pixel's centre writes, as if it were a sample.
  PathRecord record_of_centre(uint32_t p);
  /// Sums of what a plain pixel's centre sees beside its slots' light.
  std::span<Vec3d> of_centre(uint32_t p);
  /// A pixel forgets its samples, or what its centre saw.
  void begin(uint32_t p);
  /// Adds a packet's samples to their pixels.
  void add(const SamplePacket& packet, std::span<const SampleRun> runs);
  /// Adds what one of them sees to the surface that it met.
  void add_value(SeenSurface& surface, const SamplePacket& packet, uint32_t lane) const;

  /// Writes a pixel, x, y in the full frame. Returns whether something was not finite.
  bool write(uint32_t p, uint32_t x, uint32_t y, const FilteredPixel& pixel,
             const CentreLight& centres) const;

 private:
  std::vector<Vec3d> parts_of(uint32_t p, const FilteredPixel& pixel, const CentreLight& centres) const;
  std::vector<MatteHit> mattes_of(uint32_t p, const FilteredPixel& pixel) const;
  void add_slots(uint32_t p, const FilteredPixel& pixel, bool sampled, std::span<Vec3d> parts) const;

  const RenderContext& c_;
  const FilteredFrame& frame_;
  LightParts sums_, fitted_;  // over the samples, or of the centre; at the centre by samples
  std::vector<Vec3d>
      mirrored_;  // of each slot's unshadowed sum, what came by way of mirrors; if there are any
  std::vector<std::vector<MatteHit>> mattes_;
  std::vector<SeenObject> seen_;  // by the first sample
};

}  // namespace penumbra
