// SPDX-License-Identifier: GPL-3.0-or-later
#include "luminaire/sky_emitter.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "luminaire/cone.h"
#include "math/simd.h"

namespace penumbra {
namespace {

constexpr double kPi = std::numbers::pi;

/// Cells of the sphere whose light is summed up as one vector each; 2.8 degrees.
constexpr uint32_t kCellColumns = 128, kCellRows = 64;

/// Sum of max(n . a, 0), added in 16 columns.
PENUMBRA_VECTORIZED
double sum_above(const float* x, const float* y, const float* z, uint32_t count, const Vec3f& normal) {
  const Vec3f n = normal;
  constexpr uint32_t kColumns = 16;
  float sums[kColumns] = {};
  for (uint32_t i = 0; i < count; i += kColumns)
    for (uint32_t k = 0; k < kColumns; ++k) {
      const float height = x[i + k] * n.x + y[i + k] * n.y + z[i + k] * n.z;
      sums[k] += height > 0 ? height : 0.0f;
    }
  double sum = 0;
  for (float s : sums) sum += double(s);
  return sum;
}

/// Between two polar angles from straight down (radians).
struct PolarAngles {
  double across, down;

  PolarAngles(double from, double to)
      : across((to - from) / 2 - (std::sin(2 * to) - std::sin(2 * from)) / 4),
        down((std::pow(std::sin(to), 2) - std::pow(std::sin(from), 2)) / 2) {}
};

/// Between two azimuths.
struct Azimuths {
  double x, y, angle;

  Azimuths(double from, double to)
      : x(std::sin(to) - std::sin(from)), y(std::cos(from) - std::cos(to)), angle(to - from) {}
};

/// Integral of the unit direction over solid angle.
Vec3d mean_direction(const PolarAngles& polar, const Azimuths& azimuths) {
  return {polar.across * azimuths.x, polar.across * azimuths.y, -polar.down * azimuths.angle};
}

/// Turns n values into their cumulative sums from 0 to 1 at out[0 ... n]; returns the sum.
double accumulate(const double* values, uint32_t n, float* out) {
  double sum = 0;
  for (uint32_t i = 0; i < n; ++i) sum += values[i];
  double part = 0;
  for (uint32_t i = 0; i <= n; ++i) {
    out[i] = float(sum > 0 ? part / sum : double(i) / n);
    if (i < n) part += values[i];
  }
  out[n] = 1;
  return sum;
}

/// Where a cumulative table of n steps reaches x, in units of the whole table, and in which step.
struct Place {
  uint32_t step;
  float within;  // 0 ... 1
};

Place find(const float* table, uint32_t n, float x) {
  const float* above = std::upper_bound(table + 1, table + n, x);
  const auto step = uint32_t(above - table) - 1;
  const float width = table[step + 1] - table[step];
  return {step, width > 0 ? std::clamp((x - table[step]) / width, 0.0f, 1.0f) : 0.5f};
}

}  // namespace

void ConstantSky::evaluate(const SurfacePoint& surface, const float* u, const float* v, uint32_t count,
                           LightPoints& out) const {
  evaluate_hemisphere(surface.normal, u, v, count, out);
  for (float* axis : {out.x, out.y, out.z})
    for (uint32_t i = 0; i < count; ++i) axis[i] *= kBeyondScene;
}

SkyTable::SkyTable(const std::vector<float>& weights, uint32_t width, uint32_t height)
    : width_(width), height_(height), rows_(height + 1), columns_(size_t(height) * (width + 1)) {
  for (uint32_t row = 0; row <= height; ++row) heights_.push_back(float(-std::cos(kPi * row / height)));
  std::vector<double> powers(height), pixels(width);
  for (uint32_t row = 0; row < height; ++row) {
    std::copy_n(weights.begin() + std::ptrdiff_t(row) * width, width, pixels.begin());
    // The share of the sphere between two polar angles is half the difference of their cosines.
    const double share = (std::cos(kPi * row / height) - std::cos(kPi * (row + 1) / height)) / 2;
    powers[row] = accumulate(pixels.data(), width, &columns_[size_t(row) * (width + 1)]) / width * share;
  }
  mean_ = accumulate(powers.data(), height, rows_.data());
  sum_cells(weights);
}

/// Every pixel's light as a vector, added to its cell's; large pixels are cut up first.
void SkyTable::sum_cells(const std::vector<float>& weights) {
  const uint32_t nx = (kCellColumns + width_ - 1) / width_, ny = (kCellRows + height_ - 1) / height_;
  const uint32_t columns = width_ * nx, rows = height_ * ny;
  std::vector<Vec3d> cells(size_t(kCellColumns) * kCellRows);
  const double theta = kPi / rows, phi = 2 * kPi / columns;
  std::vector<Azimuths> azimuths;
  for (uint32_t column = 0; column < columns; ++column)
    azimuths.emplace_back(kPi - phi * (column + 1), kPi - phi * column);
  for (uint32_t row = 0; row < rows; ++row) {
    const PolarAngles polar(theta * row, theta * (row + 1));
    for (uint32_t column = 0; column < columns; ++column) {
      const float weight = weights[size_t(row / ny) * width_ + column / nx];
      if (!(weight > 0)) continue;
      cells[size_t(uint64_t(row) * kCellRows / rows) * kCellColumns +
            size_t(uint64_t(column) * kCellColumns / columns)] +=
          mean_direction(polar, azimuths[column]) * double(weight);
    }
  }
  const double scale = mean_ > 0 ? 1 / (kPi * mean_) : 0;
  for (const Vec3d& cell : cells) {
    const Vec3f v(cell * scale);
    x_.push_back(v.x);
    y_.push_back(v.y);
    z_.push_back(v.z);
  }
}

Vec3f SkyTable::direction(float u, float v) const {
  const Place row = find(rows_.data(), height_, v);
  const Place column = find(&columns_[size_t(row.step) * (width_ + 1)], width_, u);
  const float low = heights_[row.step], high = heights_[row.step + 1];
  const float z = low + (high - low) * row.within, sine = std::sqrt(std::max(1 - z * z, 0.0f));
  const float azimuth = float(kPi) * (1 - 2 * (float(column.step) + column.within) / float(width_));
  return {sine * std::cos(azimuth), sine * std::sin(azimuth), z};
}

double SkyTable::form_factor(const Vec3f& normal) const {
  return sum_above(x_.data(), y_.data(), z_.data(), uint32_t(x_.size()), normal);
}

PictureSky::PictureSky(std::shared_ptr<const SkyTable> table, const Affine& local_from_world)
    : table_(std::move(table)) {
  for (int i = 0; i < 3; ++i)
    axes_[i] = Vec3f(local_from_world.inverse_vector({double(i == 0), double(i == 1), double(i == 2)}));
}

double PictureSky::form_factor(const SurfacePoint& surface) const {
  const Vec3f n(surface.normal);
  return table_->form_factor({dot(axes_[0], n), dot(axes_[1], n), dot(axes_[2], n)});
}

/// A density in proportion to radiance leaves mean x 4 pi x cos / pi, over the mean.
void PictureSky::evaluate(const SurfacePoint& surface, const float* u, const float* v, uint32_t count,
                          LightPoints& out) const {
  const Vec3f normal(surface.normal);
  for (uint32_t i = 0; i < count; ++i) {
    const Vec3f local = table_->direction(u[i], v[i]),
                d = axes_[0] * local.x + axes_[1] * local.y + axes_[2] * local.z;
    out.x[i] = d.x * kBeyondScene;
    out.y[i] = d.y * kBeyondScene;
    out.z[i] = d.z * kBeyondScene;
    out.form_factor[i] = 4 * std::max(dot(d, normal), 0.0f);
  }
}

}  // namespace penumbra
