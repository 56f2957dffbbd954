// SPDX-License-Identifier: GPL-3.0-or-later
// The surfaces that an edge pixel shows, and what share of it each has. Camera rays alone tell the shares, at
// a fourth of a whole sample's price: two-phase sampling for stratification (Neyman 1938; Cochran, Sampling
// Techniques, chapter 12).
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "render/path_record.h"
#include "visibility/geometry.h"

namespace penumbra {

/// Values of a surface without samples.
inline constexpr uint32_t kMostProbes = 3;

/// How many there were up to now, and up to the two powers of two of samples before.
struct LevelCounts {
  uint32_t now = 0, power = 0, half = 0;

  void mark() {
    half = power;
    power = now;
  }
  /// In block b of a level's: of two halves of a power of two, else of three thirds.
  uint32_t in_block(int b, bool power_of_two) const {
    const uint32_t ends[4] = {0, power_of_two ? power : half, power_of_two ? now : power, now};
    return ends[b + 1] - ends[b];
  }
};

/// Light and opacity, of one sample or a mean of many.
struct Appearance {
  Vec3d value;
  double alpha = 0;

  void add(const Appearance& s, double weight) {
    value += s.value * weight;
    alpha += s.alpha * weight;
  }
};

/// What passes want to know of a surface.
struct SurfaceExtras {
  std::vector<Vec3d> parts;      // sums over its values
  std::vector<MatteHit> mattes;  // of the first one
};

/// A surface, and what is known of its part of the pixel.
struct SeenSurface {
  Facet facet;                    // where it was met first
  Primitive last;                 // where last, as far as triangles were compared
  uint32_t indices[kMostProbes];  // of the first rays that met it
  double step = 0;                // largest between its facets: step_between()
  LevelCounts rays, samples;      // that met it
  uint32_t valued = 0;            // samples whose values are known, in the sums:
  Vec3d value;
  double alpha = 0, x = 0, xx = 0;        // x: values in display units; xx: their squares
  std::unique_ptr<SurfaceExtras> extras;  // where passes want them

  void forget_values() {
    valued = 0;
    extras = nullptr;
    value = {};
    alpha = x = xx = 0;
  }
  void add_value(const Appearance& one, double display_scale) {
    const double size = max_component(one.value) * display_scale;
    ++valued;
    value += one.value;
    alpha += one.alpha;
    x += size;
    xx += size * size;
  }
  /// So many values tell its mean: of a flat one, on which unshadowed light varies slowly, one does.
  uint32_t wanted_values(bool in_penumbra) const {
    return facet.flat && !in_penumbra ? 1 : std::min(kMostProbes, rays.now);
  }
  Appearance mean() const { return {value / valued, alpha / valued}; }
  /// Mean squared difference from the mean, display units.
  double spread() const { return std::max(xx - x * x / valued, 0.0) / valued; }
};

class PixelSights {
 public:
  PixelSights() { surfaces_.reserve(2); }

  /// Number of the surface of what a ray meets first. The last one stands for all that come after it: rays
  /// must come in their order.
  uint32_t surface_of(const Geometry& geometry, const Primitive& met);
  /// All of the first rays met one surface.
  void begin(const Geometry& geometry, const Primitive& met, uint32_t rays);
  /// Each ray met another, or a quarter of them more surfaces than are told apart.
  bool shows_many() const;
  SeenSurface& operator[](uint32_t surface) { return surfaces_[surface]; }
  const std::vector<SeenSurface>& surfaces() const { return surfaces_; }
  std::vector<SeenSurface>& surfaces() { return surfaces_; }

  /// Sample `index` is one more camera ray, unless it was before it was a whole sample.
  void count_ray(uint32_t surface, uint32_t index);
  uint32_t rays() const { return rays_; }

  /// Weight of each surface's mean value in what the rays beyond `samples` add to the samples' mean: the
  /// difference of its shares.
  double weight(const SeenSurface& s, uint32_t samples) const {
    return samples > 0 ? share(s) - double(s.samples.now) / samples : share(s);
  }
  /// Of the pixel.
  double share(const SeenSurface& s) const { return double(s.rays.now) / rays_; }
  Appearance correction(uint32_t samples) const;

  /// What a block of samples would see if each surface showed its mean.
  Appearance block(LevelCounts SeenSurface::*counts, int block, bool power_of_two, double size) const;

  /// Mean squares in display units: of the surfaces' difference from the pixel's mean, and of values' from
  /// their surface's.
  double spread_between(double display_scale) const;
  double spread_within() const;
  /// Variance of the correction by what is not known of the surfaces' means. slope: by how much light is
  /// known to differ a pixel further, display units; below 0: not known.
  double mean_variance(uint32_t samples, double slope) const;

  /// The samples, or the rays, so far are a power of two.
  void mark_samples();
  void mark_rays();
  /// After the rays up to a level: the variance of the shares' part, display units squared, that its blocks
  /// tell. dimensions: of a ray.
  double close_rays(double display_scale, double dimensions);
  bool has_new_rays() const { return rays_ != closed_; }

 private:
  std::vector<SeenSurface> surfaces_;
  uint32_t rays_ = 0, closed_ = 0;
};

/// Squared deviations of a level's estimates by its blocks from their mean, as the variance of the whole; the
/// larger of the light's largest component and of opacity. The blocks of an edge in so many dimensions: the
/// variance falls as n^-(1 + 1 / dimensions).
double variance_of_blocks(std::span<const Vec3d> values, std::span<const double> alphas, double display_scale,
                          double dimensions);

}  // namespace penumbra
