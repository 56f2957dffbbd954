// SPDX-License-Identifier: GPL-3.0-or-later
// Pixels with edges, of surfaces or of shadows, refined until the estimate is within the tolerance. What
// share each surface has of a pixel is asked of camera rays alone. Its light is what the pixel's centre and a
// few places on other surfaces tell, where that is enough (a centred pixel); else whole samples are taken all
// over the filter, and a luminaire that may be partly hidden is looked at in many points from each.
#pragma once

#include <deque>

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

  /// Tells a centred pixel what light arrives at its centre, and by how much it differs a pixel further, in
  /// display units; kKeptForSights of the tolerance is charged in its error.
  void set_centre(uint32_t p, const PixelLight& light, double slope);

  /// Refines one tile's edges (all of them).
  void refine(std::span<const uint32_t> edges, const Rectangle& tile);

 private:
  std::span<Slot> slots(uint32_t p) { return frame_.of_pixel(p); }
  bool may_be_centred(uint32_t p) const;
  bool stays_centred(uint32_t p) const;
  bool wants_split(uint32_t p) const;
  void value_surfaces(std::span<const uint32_t> pixels);
  PlainSlopes slopes_around(uint32_t p) const;
  void begin_centred(std::span<const uint32_t> pixels);
  void first_level(std::span<const uint32_t> pixels, std::span<const uint32_t> anew);
  void mark_unseen(uint32_t p);
  bool split_slots(uint32_t p);
  void begin_sights(uint32_t p);
  void close_level(std::span<const uint32_t> pixels);
  bool advance(uint32_t p, const PixelVariance& variance);

  const RenderContext& c_;
  const Block& block_;
  FilteredFrame& frame_;
  std::vector<FilteredPixel>& pixels_;
  FilteredSamples& samples_;
  std::deque<EdgeState> states_;
  double tolerance_;
  ErrorModel model_;
};

}  // namespace penumbra
