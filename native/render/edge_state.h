// SPDX-License-Identifier: GPL-3.0-or-later
// What is known of a pixel with edges, level by level, and how sure its estimate is.
#pragma once

#include <span>
#include <vector>

#include "render/pixel_sights.h"
#include "render/slot.h"
#include "sampling/pixel_light_sampler.h"

namespace penumbra {

struct FilteredPixel;

/// A pixel's sums up to some sample.
struct LevelSums {
  LevelSums() = default;
  LevelSums(const FilteredPixel& pixel, std::span<const Slot> slots);

  Vec3d background;
  double alpha = 0;
  std::vector<SlotSums> slots;
};

/// How errors of filtered pixels fall.
struct ErrorModel {
  double display_scale;
  int dimensions;  // of a sample

  /// Of the standard error's n^-e: of the light on surfaces, and of the surfaces' shares.
  double light_exponent() const { return 0.5 + 0.6 / dimensions; }
  double share_exponent() const { return 0.5 + 0.6 / (dimensions - kLightDimensions); }
};

/// One part of an estimate's variance, display units squared, as if of one sample: it falls as n^-2e.
struct PartVariance {
  double by_blocks = 0;  // as the pixel's own blocks tell it
  double expected = 0;   // before any block is asked; for c = 1
  double fall = 1;       // n^-2e
};

struct EdgeState {
  PixelSights sights;
  uint32_t closed = 0;          // samples of the last level
  bool shows_many = false;      // surfaces, now or before
  double slope = -1;            // of light that is known without samples, display units a pixel
  double centre_error = 0;      // reported of light at the pixel's centre, where that serves; display units
  int32_t centre_surface = -1;  // number of the one there, if camera rays met it
  PartVariance shares, light;   // of the surfaces in the pixel; of the light on them
  double unknown = 0;           // variance of what neighbours can't help with, display units squared
  LevelSums half, power;        // at the two powers of two before

  bool is_of_centre(const SeenSurface& surface) const {
    return centre_surface >= 0 && &surface == &sights.surfaces()[size_t(centre_surface)];
  }
  /// Of the pixel, that surface's; none.
  double centre_share() const {
    return centre_surface < 0 ? 0 : sights.share(sights.surfaces()[size_t(centre_surface)]);
  }
  /// After the samples, or the rays, or both up to a level: what they tell of the variances. Remembers the
  /// sums.
  void close_level(const FilteredPixel& pixel, std::span<const Slot> slots, const ErrorModel& model);

 private:
  void close_samples(const FilteredPixel& pixel, std::span<const Slot> slots, const ErrorModel& model);
  void close_rays(const FilteredPixel& pixel, std::span<const Slot> slots, const ErrorModel& model);
  double variance_of_level(const FilteredPixel& pixel, std::span<const Slot> slots, const ErrorModel& model);
};

}  // namespace penumbra
