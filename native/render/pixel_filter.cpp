// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/pixel_filter.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "math/simd.h"
#include "sampling/sampler.h"

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

constexpr int kIntervals = 4096, kQuantiles = 2048;

/// Integral of the window up to quantile k: dense where the window is thin.
double mass(int k) {
  return 0.5 * (double(k) / kQuantiles) * (double(k) / kQuantiles);
}

PENUMBRA_VECTORIZED
void interpolate(const double* quantiles, const float* variates, uint32_t count, double* out) {
  alignas(64) double result[kPacket];  // `out` might alias the table
  for (uint32_t i = 0; i < count; ++i) {
    const double x = double(variates[i]), other = 1 - x, tail = x < other ? x : other;
    const double side = x < other ? -1.0 : 1.0, place = std::sqrt(2 * tail) * kQuantiles;
    const int floor = int(place), k = floor < kQuantiles - 1 ? floor : kQuantiles - 1;
    const double low = quantiles[k], high = quantiles[k + 1];
    result[i] = side * (low + (place - double(k)) * (high - low));
  }
  for (uint32_t i = 0; i < count; ++i) out[i] = result[i];
}

}  // namespace

PixelFilter::PixelFilter(FilterKind kind, double width)
    : support_(kind == FilterKind::kBox ? width : 2 * width),
      variance_(support_ * support_ / 12),
      mean_distance_(support_ / 4) {
  if (kind == FilterKind::kBox) return;
  variance_ = mean_distance_ = 0;
  double low = 0;  // integral up to the interval
  for (int i = 0, k = 0; i < kIntervals / 2; ++i) {
    const double high = i + 1 < kIntervals / 2 ? blackman_harris_integral(double(i + 1) / kIntervals) : 0.5;
    const double x = ((i + 0.5) / kIntervals - 0.5) * support_;
    variance_ += 2 * x * x * (high - low);
    mean_distance_ += 2 * std::abs(x) * (high - low);
    for (; k <= kQuantiles && mass(k) <= high; ++k)
      quantiles_.push_back((0.5 - (i + (mass(k) - low) / (high - low)) / kIntervals) * support_);
    low = high;
  }
}

double PixelFilter::reach_of(double share) const {
  if (quantiles_.empty()) return (0.5 - share) * support_;
  return quantiles_[size_t(std::sqrt(2 * share) * kQuantiles)];
}

void PixelFilter::offsets(const float* x, uint32_t count, double* out) const {
  if (quantiles_.empty())
    for (uint32_t i = 0; i < count; ++i) out[i] = (double(x[i]) - 0.5) * support_;
  else
    interpolate(quantiles_.data(), x, count, out);
}

}  // namespace penumbra
