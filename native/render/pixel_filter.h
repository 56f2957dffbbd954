// SPDX-License-Identifier: GPL-3.0-or-later
// The pixel filter, importance sampled: a uniform variate becomes an offset from the pixel's centre.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

namespace penumbra {

enum class FilterKind { kBox, kBlackmanHarris };

/// Separable and positive, so that all samples have weight 1.
class PixelFilter {
 public:
  /// width: as Cycles has it, of a box the whole support in pixels, of Blackman-Harris half of it.
  PixelFilter(FilterKind kind, double width);

  /// Whole width in pixels of the square that offsets lie in.
  double support() const { return support_; }
  /// Pixels to each side whose edges it sees.
  int reach() const { return int(std::ceil(support_ / 2)); }
  /// Distance from the centre along one axis beyond which, to one side, lies at most that share of it (at
  /// most a half).
  double reach_of(double share) const;
  /// Second moment of the offsets along one axis, pixels squared.
  double variance() const { return variance_; }
  /// Mean distance from the centre along one axis, pixels.
  double mean_distance() const { return mean_distance_; }

  /// Offsets in pixels, distributed as the filter. x in [0, 1); count: at most kPacket.
  void offsets(const float* x, uint32_t count, double* out) const;

 private:
  double support_, variance_, mean_distance_;
  // Distances from the centre within which lies all but so much of one half: of its share (k / n)^2; linear
  // in between. Empty for a box, whose inverse is linear.
  std::vector<double> quantiles_;
};

}  // namespace penumbra
