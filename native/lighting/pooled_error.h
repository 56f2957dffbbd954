// SPDX-License-Identifier: GPL-3.0-or-later
// How sure BOUNDED is of an estimate. Two or three blocks of its own points tell its variance, but with much
// noise; so that is pooled with what its neighbours' blocks tell, and with what is expected before any does.
#pragma once

#include <cmath>

namespace penumbra {

/// Calibrated constants; how they were found: tests/benchmarks/README.md. Guarded by
/// tests/python/test_bounded.py and test_bounded_filtered.py.
struct BoundedCalibration {
  /// Quantile that stopping tests, in units of the estimated standard error: about 99 % of the pixels.
  double stop;
  /// Quantile of the Error Estimate pass: 95 %.
  double report;
  /// What an estimate's error is expected to be: c times its smoothed standard error, s n^-e of points with
  /// standard deviation s; and how many neighbours that counts as.
  double smoothed, prior_weight;
};

/// Of one luminaire from one surface point, e = 3/4: an edge through the luminaire.
inline constexpr BoundedCalibration kItemCalibration{2.85, 2.2, 1.2, 6.0};
/// By lines across the luminaire, e = 3/2. Errors are more often small than a normal distribution's.
inline constexpr BoundedCalibration kLineCalibration{2.85, 1.55, 0.3, 2.0};
static_assert(kLineCalibration.stop == kItemCalibration.stop, "a pixel may have both");
/// Of a filtered pixel, e = 1/2 + 0.6 / dimensions: between n^-5/8, of an edge in four dimensions, and
/// n^-3/4, in two.
inline constexpr BoundedCalibration kPixelCalibration{3.0, 2.2, 1.0, 6.0};

/// The whole's variance as a share of the sum of squared deviations of the estimates by B blocks from their
/// mean: one block's variance is B^exponent times the whole's. exponent: 3/2 for an edge through the
/// luminaire (Owen-scrambled nets), 1 for independent points.
inline double share_of_blocks(int blocks, double exponent) {
  return 1 / ((blocks - 1) * std::pow(blocks, exponent));
}

/// The mean of a prior and of neighbours' variances.
class PooledVariance {
 public:
  /// weight: how many neighbours the prior counts as.
  PooledVariance(double prior, double weight) : sum_(prior * weight), weight_(weight) {}

  /// count_ratio: how many times the points of the estimate asked about it is from; variances fall as
  /// n^-fall.
  void add(double variance, double count_ratio, double fall) {
    add(count_ratio == 1 ? variance : variance * std::pow(count_ratio, fall));
  }
  void add(double variance) {
    sum_ += variance;
    ++weight_;
  }

  double mean() const { return sum_ / weight_; }

 private:
  double sum_, weight_;
};

}  // namespace penumbra
