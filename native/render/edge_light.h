// SPDX-License-Identifier: GPL-3.0-or-later
// Pixels with edges, of surfaces or of shadows: samples all over the filter, until the estimate is within the
// tolerance. What share each surface has of a pixel is asked of camera rays alone, and a luminaire that may
// be partly hidden is looked at in many points from each sample.
#pragma once

#include "render/filtered_samples.h"
#include "render/tile_error.h"

namespace penumbra {

class EdgeLight {
 public:
  EdgeLight(const RenderContext& context, const Block& block, FilteredFrame& frame,
            std::vector<FilteredPixel>& pixels, FilteredSamples& samples);

  /// The first level of a quad's edges, of those so far from the core at most, or anew where what their
  /// samples found wants more rays.
  void start(std::span<const uint32_t> quad, int margin);

  /// Refines one tile's edges (all of them).
  void refine(std::span<const uint32_t> edges);

 private:
  std::span<Slot> slots(uint32_t p) { return frame_.of_pixel(p); }
  void first_level(std::span<const uint32_t> pixels, std::span<const uint32_t> anew);
  void mark_unseen(uint32_t p);
  bool split_slots(uint32_t p);
  void begin_sights(uint32_t p);
  void close_level(uint32_t p);
  bool advance(uint32_t p, const PixelVariance& variance);

  const RenderContext& c_;
  const Block& block_;
  FilteredFrame& frame_;
  std::vector<FilteredPixel>& pixels_;
  FilteredSamples& samples_;
  double tolerance_;
  ErrorModel model_;
};

}  // namespace penumbra
