// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/pixel_filter.h"

#include <cmath>
#include <numbers>

namespace penumbra {
namespace {

/// Integral of the four-term Blackman-Harris window (F. J. Harris 1978, 92 dB) over [0, x], x in [0, 1]; the
/// cosine terms integrate to zero over the whole, so that its value at 1 is the constant term.
double blackman_harris_integral(double x) {
  constexpr double kA[4] = {0.35875, 0.48829, 0.14128, 0.01168};
  double sum = kA[0] * x;
  for (int k = 1; k < 4; ++k) {
    const double frequency = 2 * std::numbers::pi * k;
    sum += (k % 2 ? -1 : 1) * kA[k] * std::sin(frequency * x) / frequency;
  }
  return sum / kA[0];
}

constexpr int kIntervals = 1024;

}  // namespace

PixelFilter::PixelFilter(FilterKind kind, double width)
    : support_(kind == FilterKind::kBox ? width : 2 * width), variance_(support_ * support_ / 12) {
  if (kind == FilterKind::kBox) return;
  cumulative_.resize(kIntervals + 1);
  for (int i = 0; i <= kIntervals; ++i) cumulative_[i] = blackman_harris_integral(double(i) / kIntervals);
  variance_ = 0;
  for (int i = 0; i < kIntervals; ++i) {
    const double x = ((i + 0.5) / kIntervals - 0.5) * support_;
    variance_ += x * x * (cumulative_[i + 1] - cumulative_[i]);
  }
  for (int k = 0, i = 0; k <= kIntervals; ++k) {
    while (i + 1 < kIntervals && cumulative_[i + 1] <= double(k) / kIntervals) ++i;
    guide_.push_back(uint16_t(i));
  }
}

double PixelFilter::offset(double x) const {
  if (cumulative_.empty()) return (x - 0.5) * support_;
  // Linear between the table's places: the filter becomes a histogram of 1024 steps.
  int i = guide_[size_t(x * kIntervals)];
  while (i + 1 < kIntervals && cumulative_[i + 1] <= x) ++i;
  const double low = cumulative_[i], high = cumulative_[i + 1];
  const double fraction = high > low ? (x - low) / (high - low) : 0.5;
  return ((i + fraction) / kIntervals - 0.5) * support_;
}

}  // namespace penumbra
