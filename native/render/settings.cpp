// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/settings.h"

#include <cmath>
#include <set>
#include <sstream>
#include <stdexcept>

#include "lighting/bounded_item.h"
#include "render/film.h"

namespace penumbra {
namespace {

/// Film of more pixels than this is refused before any memory is taken.
constexpr uint64_t kMostPixels = uint64_t(1) << 30;
constexpr uint32_t kMostSamples = 1u << 24;

void require(bool condition, const std::string& message) {
  if (!condition) throw std::invalid_argument(message);
}

/// "NAME must ..., not VALUE".
template <typename T>
void require_value(bool condition, const char* name, const char* expected, T value) {
  if (condition) return;
  std::ostringstream text;
  text << name << " must " << expected << ", not " << value;
  throw std::invalid_argument(text.str());
}

void require_samples(const char* name, uint32_t value) {
  require(value >= 1 && value <= kMostSamples, std::string(name) + " must lie in 1 ... " +
                                                   std::to_string(kMostSamples) + ", not " +
                                                   std::to_string(value));
}

/// Numbers of points between which the rule does not look; none where it may look at any.
std::vector<uint32_t> levels_of(const StopSettings& stop) {
  if (stop.kind == StopRuleKind::kFixed) return {0, stop.light_samples};
  std::vector<uint32_t> levels;
  if (stop.kind == StopRuleKind::kBounded)
    for (uint32_t n = next_level(0); n <= stop.max_light_samples; n = next_level(n)) levels.push_back(n);
  return levels;
}

}  // namespace

RenderSettings RenderSettings::validated() const {
  require(width > 0 && height > 0, "width and height must be at least one pixel");
  require(uint64_t(width) * height <= kMostPixels, "width x height is more than 2^30 pixels");
  RenderSettings s = *this;
  if (s.region.width == 0 && s.region.height == 0) s.region = {0, 0, width, height};
  require(s.region.width > 0 && s.region.height > 0, "the region is empty");
  require(uint64_t(s.region.x) + s.region.width <= width && uint64_t(s.region.y) + s.region.height <= height,
          "the region reaches beyond the frame");
  require_samples("light_samples", light_samples);
  require_samples("max_light_samples", max_light_samples);
  require_samples("pixel_samples", pixel_samples);
  require_samples("max_pixel_samples", max_pixel_samples);
  require_samples("check_interval", check_interval);
  require_value(std::isfinite(error_tolerance) && error_tolerance > 0, "error_tolerance",
                "be positive and finite", error_tolerance);
  require_value(std::isfinite(exposure) && std::abs(exposure) <= 100, "exposure", "lie in -100 ... 100 stops",
                exposure);
  require_value(std::isfinite(filter_width) && filter_width > 0 && filter_width <= 10, "filter_width",
                "lie in 0 ... 10 pixels", filter_width);
  require_value(mirror_depth <= 1024, "mirror_depth", "be at most 1024", mirror_depth);
  require_value(threads <= 1024, "threads", "be at most 1024", threads);
  if (sampler == SamplerKind::kSprs) {
    require(stop_rule == StopRuleKind::kFixed,
            "sampler SPRS can't grow: it needs stop_rule FIXED, since its grid is laid out beforehand");
    const auto side = uint32_t(std::lround(std::sqrt(double(light_samples))));
    require(side * side == light_samples,
            "sampler SPRS needs a square number of light_samples, not " + std::to_string(light_samples));
  }
  if (stop_rule == StopRuleKind::kBounded) {
    require(
        sampler == SamplerKind::kOwenSobol && sample_reuse == SampleReuse::kScrambled,
        "stop_rule BOUNDED needs sampler OWEN_SOBOL with sample_reuse SCRAMBLED: its error estimate rests on "
        "them");
    require(max_light_samples >= kPacket, "stop_rule BOUNDED needs max_light_samples of at least 16");
    require(max_pixel_samples >= kPacket, "stop_rule BOUNDED needs max_pixel_samples of at least 16");
  }
  if (stop_rule == StopRuleKind::kPaper)
    require(max_light_samples >= 2 * check_interval,
            "stop_rule PAPER first compares at 2 x check_interval points: max_light_samples is below that");
  require(std::isfinite(mist.start) && std::isfinite(mist.depth) && mist.exponent > 0,
          "mist must be a finite start and depth and a positive exponent");
  for (const std::string& name : passes)
    require(pass_channels(name) > 0, "there is no pass named '" + name + "'");
  return s;
}

std::string RenderSettings::description() const {
  std::ostringstream text;
  text.precision(17);
  text << width << " x " << height << ", region " << region.x << ' ' << region.y << ' ' << region.width << ' '
       << region.height << ", rule " << int(stop_rule) << ' ' << error_tolerance << ' ' << light_samples
       << ' ' << max_light_samples << ' ' << check_interval << ", sampler " << int(sampler) << ' '
       << int(sample_reuse) << ' ' << seed << ", pixel " << pixel_samples << ' ' << max_pixel_samples << ' '
       << int(filter_type) << ' ' << filter_width << ", mirrors " << mirror_depth << ", exposure " << exposure
       << ", mist " << mist.start << ' ' << mist.depth << ' ' << mist.exponent << ", passes";
  for (const std::string& name : std::set<std::string>(passes.begin(), passes.end())) text << ' ' << name;
  return text.str();
}

BoundedSettings RenderSettings::bounded_settings(const Geometry& geometry) const {
  // Lines want a tree of the triangles, half a microsecond each. At 0.004 they save 5 microseconds a pixel in
  // loose foliage and 50 in dense (tests/benchmarks/README.md); the points that they save grow as n^-3/4.
  constexpr double kTrianglesPerPixel = 10, kTolerance = 0.004;
  const double most =
      kTrianglesPerPixel * std::pow(kTolerance / error_tolerance, 4.0 / 3) * double(width) * double(height);
  return {error_tolerance, std::exp2(exposure), max_light_samples, double(geometry.triangles()) <= most};
}

StopSettings RenderSettings::stop_settings() const {
  return {stop_rule, light_samples, max_light_samples, check_interval, error_tolerance / std::exp2(exposure)};
}

SamplerSettings RenderSettings::sampler_settings() const {
  const StopSettings stop = stop_settings();
  return {sampler, sample_reuse, seed, stop.limit(), levels_of(stop)};
}

}  // namespace penumbra
