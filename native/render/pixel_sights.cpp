// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/pixel_sights.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "lighting/pooled_error.h"

namespace penumbra {
namespace {

/// Surfaces that are told apart in one pixel.
constexpr size_t kMostSurfaces = 6;

/// Of a surface's middle in the pixel from a place where it was met, pixels.
constexpr double kPlaceDeviation = 0.5;

}  // namespace

uint32_t PixelSights::surface_of(const Geometry& geometry, const Primitive& met) {
  for (uint32_t i = 0; i < surfaces_.size(); ++i)
    if (surfaces_[i].facet.primitive == met || surfaces_[i].last == met) return i;
  const Facet facet = geometry.facet_of(met);
  for (uint32_t i = 0; i < surfaces_.size(); ++i)
    if (same_surface(surfaces_[i].facet, facet)) {
      surfaces_[i].last = met;
      surfaces_[i].step = std::max(surfaces_[i].step, step_between(surfaces_[i].facet, facet));
      return i;
    }
  if (surfaces_.size() == kMostSurfaces) return kMostSurfaces - 1;
  SeenSurface& surface = surfaces_.emplace_back();
  surface.facet = facet;
  surface.last = met;
  return uint32_t(surfaces_.size()) - 1;
}

void PixelSights::begin(const Geometry& geometry, const Primitive& met, uint32_t rays) {
  SeenSurface& surface = surfaces_[surface_of(geometry, met)];
  for (uint32_t i = 0; i < kMostProbes; ++i) surface.indices[i] = i;
  surface.rays.now = rays_ = rays;
}

bool PixelSights::shows_many() const {
  return surfaces_.size() == std::min<size_t>(rays_, kMostSurfaces) && 4 * surfaces_.back().rays.now >= rays_;
}

void PixelSights::count_ray(uint32_t surface, uint32_t index) {
  if (index < rays_) return;
  LevelCounts& rays = surfaces_[surface].rays;
  if (rays.now < kMostProbes) surfaces_[surface].indices[rays.now] = index;
  ++rays.now;
  rays_ = index + 1;
}

Appearance PixelSights::correction(uint32_t samples) const {
  Appearance sum;
  for (const SeenSurface& s : surfaces_) sum.add(s.mean(), weight(s, samples));
  return sum;
}

Appearance PixelSights::block(LevelCounts SeenSurface::*counts, int block, bool power_of_two,
                              double size) const {
  Appearance sum;
  for (const SeenSurface& s : surfaces_) sum.add(s.mean(), (s.*counts).in_block(block, power_of_two) / size);
  return sum;
}

double PixelSights::spread_between(double display_scale) const {
  Appearance mean;
  for (const SeenSurface& s : surfaces_) mean.add(s.mean(), double(s.rays.now) / rays_);
  double sum = 0;
  for (const SeenSurface& s : surfaces_) {
    const Appearance own = s.mean();
    const double difference =
        std::max(max_abs(own.value - mean.value) * display_scale, std::abs(own.alpha - mean.alpha));
    sum += difference * difference * s.rays.now / rays_;
  }
  return sum;
}

double PixelSights::spread_within() const {
  double sum = 0;
  uint32_t valued = 0;
  for (const SeenSurface& s : surfaces_) {
    sum += s.spread() * s.valued;
    valued += s.valued;
  }
  return sum / valued;
}

double PixelSights::mean_variance(uint32_t samples, double slope) const {
  double sum = 0;
  for (const SeenSurface& s : surfaces_) {
    const double w = weight(s, samples), inside = double(s.rays.now) / rays_;
    // Without an own spread, what the slope tells of two places in the pixel, of which one is the centre of a
    // surface that fills it; or its value's square.
    const double sloped = slope * (1 - inside) * kPlaceDeviation;
    const double own = s.valued > 1 ? s.spread() * s.valued / (s.valued - 1) : 0;
    sum +=
        w * w * (slope < 0 ? (s.valued > 1 ? s.spread() : s.xx) : std::max(own, sloped * sloped)) / s.valued;
  }
  return sum;
}

void PixelSights::mark_samples() {
  for (SeenSurface& s : surfaces_) s.samples.mark();
}

void PixelSights::mark_rays() {
  for (SeenSurface& s : surfaces_) s.rays.mark();
}

double PixelSights::close_rays(double display_scale, double dimensions) {
  closed_ = rays_;
  const bool power_of_two = std::has_single_bit(rays_);
  const int blocks = power_of_two ? 2 : 3;
  Vec3d values[3];
  double alphas[3];
  for (int b = 0; b < blocks; ++b) {
    const Appearance seen = block(&SeenSurface::rays, b, power_of_two, double(rays_) / blocks);
    values[b] = seen.value;
    alphas[b] = seen.alpha;
  }
  if (power_of_two) mark_rays();
  return variance_of_blocks({values, size_t(blocks)}, {alphas, size_t(blocks)}, display_scale, dimensions);
}

double variance_of_blocks(std::span<const Vec3d> values, std::span<const double> alphas, double display_scale,
                          double dimensions) {
  const double blocks = double(values.size());
  Vec3d mean, squares;
  double alpha = 0, alpha_squares = 0;
  for (const Vec3d& value : values) mean += value / blocks;
  for (const Vec3d& value : values) squares += (value - mean) * (value - mean);
  for (double a : alphas) alpha += a / blocks;
  for (double a : alphas) alpha_squares += (a - alpha) * (a - alpha);
  return std::max(max_component(squares) * display_scale * display_scale, alpha_squares) *
         share_of_blocks(int(values.size()), 1 + 1 / dimensions);
}

}  // namespace penumbra
