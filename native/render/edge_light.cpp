// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/edge_light.h"

#include <algorithm>
#include <cmath>

#include "lighting/bounded_item.h"
#include "lighting/pooled_error.h"

namespace penumbra {
namespace {

/// A whole sample's price without its rays to luminaires, and of one of these, in camera rays.
constexpr double kPriceOfSample = 3, kPriceOfRay = 0.3;

}  // namespace

EdgeLight::EdgeLight(const RenderContext& context, const Block& block, FilteredFrame& frame,
                     std::vector<FilteredPixel>& pixels, FilteredSamples& samples)
    : c_(context),
      block_(block),
      frame_(frame),
      pixels_(pixels),
      samples_(samples),
      tolerance_(context.settings.error_tolerance),
      model_{std::exp2(context.settings.exposure), context.pixel_rays.dimensions()} {}

void EdgeLight::start(std::span<const uint32_t> quad, int margin) {
  uint32_t some[4], count = 0, anew[4], anews = 0;
  for (uint32_t p : quad) {
    if (!frame_.edge[p] || !block_.in_core(p, margin)) continue;
    mark_unseen(p);
    const bool is_new = !pixels_[p].edge;
    if (is_new) begin_sights(p);
    const bool split = split_slots(p);
    if (!is_new && !split) continue;
    some[count++] = p;
    if (split) anew[anews++] = p;
  }
  first_level({some, count}, {anew, anews});
}

/// An edge pixel that gets more samples may see luminaires that its first ones did not face.
void EdgeLight::mark_unseen(uint32_t p) {
  if (!frame_.edge[p]) return;
  for (Slot& slot : slots(p)) slot.uncertain = slot.uncertain || (!slot.lit && !slot.dark);
}

/// 8 samples of at most four pixels, and as many camera rays more. anew: those of them that forget the
/// samples they have.
void EdgeLight::first_level(std::span<const uint32_t> pixels, std::span<const uint32_t> anew) {
  constexpr uint32_t kHalf = kPacket / 2;
  for (uint32_t p : anew) {
    samples_.forget(p);
    begin_sights(p);
  }
  samples_.trace_each(anew, 0, kFirstSamples);
  for (uint32_t p : pixels) {
    pixels_[p].edge->remember_power(pixels_[p], slots(p));
    pixels_[p].edge->sights.mark_samples();
  }
  samples_.trace_each(pixels, kFirstSamples, kHalf - kFirstSamples);
  for (uint32_t p : pixels) pixels_[p].edge->sights.mark_rays();
  samples_.look_each(pixels, kHalf, kHalf);
  for (uint32_t p : pixels) close_level(p);
}

/// Where 16 samples of one point each would leave too much noise, samples take more of them: cheaper than
/// more samples, but where many surfaces are seen, as in foliage: there the noise is of places in the pixel.
/// Returns whether the pixel has slots where that is new.
bool EdgeLight::split_slots(uint32_t p) {
  FilteredPixel& pixel = pixels_[p];
  EdgeState& edge = *pixel.edge;
  edge.shows_many = edge.shows_many || edge.sights.shows_many();
  if (edge.shows_many) {
    for (Slot& slot : slots(p)) slot.split = false;
    return false;
  }
  double squares = 0;
  const auto size = [&](const Slot& slot) {
    return max_abs(slot.now.unshadowed) / pixel.count * model_.display_scale;
  };
  for (const Slot& slot : slots(p))
    if (slot.uncertain) squares += size(slot) * size(slot);
  const double noise = kPixelCalibration.stop * 0.5 * std::pow(kPacket, -model_.light_exponent());
  if (noise * noise * squares <= tolerance_ * tolerance_) return false;
  const uint32_t lobes = frame_.glossy ? 2 : 1;
  bool some = false;
  for (uint32_t s = 0; s < frame_.slot_count; s += lobes) {
    const std::span<Slot> pair = slots(p).subspan(s, lobes);
    if (pair[0].split || !(pair[0].uncertain || pair[lobes - 1].uncertain)) continue;
    if (c_.luminaires[s / lobes % c_.luminaires.size()].is_point()) continue;
    for (Slot& slot : pair) slot.split = true;
    some = true;
  }
  return some;
}

/// Which surfaces the samples met that the pixel has from the first look.
void EdgeLight::begin_sights(uint32_t p) {
  FilteredPixel& pixel = pixels_[p];
  pixel.edge = std::make_unique<EdgeState>();
  PixelSights& sights = pixel.edge->sights;
  for (uint32_t i = 0; i < pixel.count; ++i) {
    const uint32_t k = sights.surface_of(c_.geometry, pixel.met[i], i);
    sights.count_ray(k, i);
    ++sights[k].samples.now;
  }
}

/// The pixel's samples, or its rays, or both, are a level.
void EdgeLight::close_level(uint32_t p) {
  samples_.probe_surfaces(p);
  pixels_[p].edge->close_level(pixels_[p], slots(p), model_);
}

/// One level more for a pixel: of samples, or of camera rays alone, whichever takes more from its variance
/// for the price. Returns whether there was one.
bool EdgeLight::advance(uint32_t p, const PixelVariance& variance) {
  FilteredPixel& pixel = pixels_[p];
  if (split_slots(p)) {
    first_level({&p, 1}, {&p, 1});
    return true;
  }
  const uint32_t rays = pixel.edge->sights.rays(), most = c_.settings.max_pixel_samples;
  const double price = kPriceOfSample + kPriceOfRay * double(pixel.light_points) / pixel.count;
  const bool wants_rays = variance.shares * price * pixel.count > variance.light * rays;
  if (wants_rays && next_level(rays) <= most) {
    for (uint32_t first = rays; first < next_level(rays); first += kPacket)
      samples_.look_each({&p, 1}, first, kPacket);
  } else {
    const uint32_t target = next_level(pixel.count);
    if (target > most) return false;
    while (pixel.count < target)
      samples_.trace_each({&p, 1}, pixel.count, std::min(kPacket, target - pixel.count));
  }
  close_level(p);
  return true;
}

void EdgeLight::refine(std::span<const uint32_t> edges) {
  TileError errors(pixels_, frame_, edges, tolerance_);
  std::vector<uint32_t> open(edges.begin(), edges.end());
  std::vector<std::pair<uint32_t, PixelVariance>> again;
  while (!open.empty()) {
    again.clear();
    errors.learn();
    for (uint32_t p : open) {
      FilteredPixel& pixel = pixels_[p];
      const PixelVariance variance = errors.of(p);
      const double error = std::sqrt(variance.shares + variance.light), charged = pixel.charged / pixel.count;
      pixel.error = kPixelCalibration.report * error + charged;
      const double bound = kPixelCalibration.stop * error + charged;
      if (bound > tolerance_ &&
          bound > tolerance_ * max_component(pixel.estimate(slots(p))) * model_.display_scale)
        again.push_back({p, variance});
    }
    open.clear();
    for (const auto& [p, variance] : again) {
      pixels_[p].at_limit = !advance(p, variance);
      if (!pixels_[p].at_limit) open.push_back(p);
    }
  }
}

}  // namespace penumbra
