// SPDX-License-Identifier: GPL-3.0-or-later
// What BOUNDED with antialiasing knows of a pixel, and how sure it is of it.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "render/film.h"
#include "render/paths.h"
#include "render/pixel_sights.h"
#include "sampling/pixel_light_sampler.h"

namespace penumbra {

/// Samples of the first look at every pixel.
inline constexpr uint32_t kFirstSamples = 4;

/// Sums over a pixel's samples for one slot: one luminaire, one lobe, one number of mirrors before.
struct SlotSums {
  Vec3d unshadowed;      // radiance without visibility; exact for the diffuse lobe
  double w = 0, wv = 0;  // weight of the sampled point, and weight times visibility

  friend SlotSums operator-(const SlotSums& a, const SlotSums& b) {
    return {a.unshadowed - b.unshadowed, a.w - b.w, a.wv - b.wv};
  }
};

struct Slot {
  SlotSums now;
  Vec3d fitted;  // unshadowed radiance at the pixel's centre, by a plane through the first samples
  bool lit = false, dark = false;  // seen by some ray
  bool uncertain = false;
  bool split = false;  // each sample looks at as many points as a packet holds
  uint32_t rays = 0;   // samples whose point on the luminaire was above the horizon, and looked at

  Slot() {}  // without it a vector of them is zeroed once more
  /// Radiance from `s`, sums over `count` samples: unshadowed mean x visible fraction.
  Vec3d radiance(const SlotSums& s, double count) const { return s.unshadowed / count * visible(s); }
  Vec3d fitted_radiance() const { return fitted * (lit ? 1.0 : 0.0); }

 private:
  double visible(const SlotSums& s) const {
    if (!uncertain) return lit ? 1.0 : 0.0;
    return s.w > 0 ? s.wv / s.w : now.w > 0 ? now.wv / now.w : 0.0;
  }
};

/// A pixel's sums up to some sample.
struct LevelSums {
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

struct FilteredPixel {
  FilteredPixel() {}  // as above

  uint32_t count = 0, closed = 0;  // samples; those of the last level
  bool at_limit = false;
  bool shows_many = false;              // surfaces, now or before
  Vec3d background, background_fitted;  // sum; at the centre
  double alpha = 0;                     // sum
  PartVariance shares, light_variance;  // of the surfaces in it; of the light on them
  double unknown_variance = 0;          // of what neighbours can't help with, display units squared
  double charged = 0;                   // error of what was left out, display units
  double error = 0;                     // reported
  uint64_t light_points = 0;
  FirstSight first;              // of the first sample
  Primitive met[kFirstSamples];  // by the first samples' camera rays
  /// At the two powers of two before; few pixels have levels.
  struct History {
    LevelSums half, power;
  };
  std::unique_ptr<History> history;
  std::unique_ptr<PixelSights> sights;  // of edges

  /// Before any sample.
  void begin() {
    count = closed = 0;
    background = {};
    alpha = charged = 0;
  }
  /// From all samples.
  PixelLight light(std::span<const Slot> slots) const {
    return {estimate(slots), error, light_points, at_limit};
  }
  /// From all samples and camera rays so far.
  Vec3d estimate(std::span<const Slot> slots) const;
  double opacity() const;
  /// What the samples would be, if nothing hid anything: what unseen occluders can be wrong about.
  Vec3d unshadowed(std::span<const Slot> slots) const;
  /// From the first samples and the certain slots alone: at the pixel's centre.
  Vec3d fitted(std::span<const Slot> slots) const;
  /// Half of the first level is done.
  void remember_power(std::span<const Slot> slots);
  /// After the samples, or the rays, or both up to a level: what they tell of the variances. Remembers the
  /// sums.
  void close_level(std::span<const Slot> slots, const ErrorModel& model);

 private:
  void close_samples(std::span<const Slot> slots, const ErrorModel& model);
  void close_rays(std::span<const Slot> slots, const ErrorModel& model);
  double unknown(std::span<const Slot> slots, double display_scale) const;
  double variance_of_level(std::span<const Slot> slots, const ErrorModel& model);
  double blind_variance(std::span<const Slot> slots, const ErrorModel& model) const;
};

/// What the pixel's samples decided about each luminaire, for --debug-pixel. lobes: of each luminaire in the
/// slots. smooth: uncertain slots are told of elsewhere.
void tell(PixelTrace& trace, const FilteredPixel& pixel, std::span<const Slot> slots, uint32_t luminaires,
          uint32_t lobes, bool smooth);

/// A plane may leave the side of zero that its samples are on, as light that is taken away is below it: zero
/// there, r, g, b. samples: their sum.
Vec3d same_side(const Vec3d& plane, const Vec3d& samples);

/// Do two samples see different surfaces?
bool edge_between(const FirstSight& a, const FirstSight& b);

/// Weights h of four samples at offsets (x, y) from the pixel's centre, such that sum h f is f's value there
/// for every linear f (the intercept of the least-squares plane), and weights r such that |sum r f| is the
/// residual. Equal weights, and no residual, where the points are nearly on a line.
struct PlaneFit {
  std::array<double, kFirstSamples> h, r;
  PlaneFit(const double* x, const double* y);
};

}  // namespace penumbra
