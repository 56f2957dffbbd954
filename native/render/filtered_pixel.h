// SPDX-License-Identifier: GPL-3.0-or-later
// What BOUNDED with antialiasing knows of a pixel, and how sure it is of it.
#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "render/edge_state.h"
#include "render/film.h"
#include "render/paths.h"

namespace penumbra {

/// What a plain pixel's neighbours on the same surface tell of unshadowed light around its centre.
struct PlainSlopes {
  float slope = 0;  // largest difference between centres, display units
  float bend = 0;   // of the filtered value from that at the centre; infinite where nothing tells
};

struct FilteredPixel {
  FilteredPixel() {}  // as above

  uint32_t count = 0;  // samples; 0: what is known was seen through the centre, as if by one
  bool plain = false;  // seen so at first
  bool at_limit = false;
  Vec3d background, background_fitted;  // sum; at the centre
  double alpha = 0;                     // sum
  double charged = 0;                   // error of what was left out, display units, sum
  double error = 0;                     // reported
  uint64_t light_points = 0;
  FirstSight first;        // of the centre or the first sample
  Primitive centre;        // what a plain pixel's centre met
  uint32_t material;       // there
  uint8_t joined = 0;      // to which neighbours before it by the same surface: kJoinedTo
  uint8_t parted = 0;      // from which there is an edge
  bool sees_more = false;  // than its centre, by camera rays around it
  bool bent = false;       // light at the centre is not the filtered pixel's
  PlainSlopes slopes;
  Vec3d centre_light;            // its light, if nothing hid anything
  Primitive met[kFirstSamples];  // by the first samples' camera rays
  EdgeState* edge = nullptr;     // few pixels have one

  /// Before any sample.
  void begin() {
    count = 0;
    background = {};
    alpha = charged = 0;
  }
  /// An edge whose surfaces are told by camera rays alone: light comes from the centre of the pixel, and of
  /// single places on what else it shows.
  bool centred() const { return edge && count == 0; }
  /// Of the sums.
  double samples() const { return std::max(count, 1u); }
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

/// Share of the tolerance that taking a plain pixel's centre for all of it may cost.
inline constexpr double kBendShare = 0.3;

/// Of FilteredPixel::joined: to the left one and the one below.
inline constexpr uint8_t kJoinedTo[2] = {1, 2};

/// From its own and its neighbours' centres.
PlainSlopes plain_slopes(std::span<const FilteredPixel> pixels, uint32_t block_width, uint32_t pixel,
                         double filter_variance, double display_scale);

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
