// SPDX-License-Identifier: GPL-3.0-or-later
// What BOUNDED with antialiasing knows of a pixel, and how sure it is of it.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "render/edge_state.h"
#include "render/film.h"
#include "render/paths.h"

namespace penumbra {

struct FilteredPixel {
  FilteredPixel() {}  // as above

  uint32_t count = 0;  // samples
  bool at_limit = false;
  Vec3d background, background_fitted;  // sum; at the centre
  double alpha = 0;                     // sum
  double charged = 0;                   // error of what was left out, display units
  double error = 0;                     // reported
  uint64_t light_points = 0;
  FirstSight first;                 // of the first sample
  Primitive met[kFirstSamples];     // by the first samples' camera rays
  std::unique_ptr<EdgeState> edge;  // few pixels have one

  /// Before any sample.
  void begin() {
    count = 0;
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
