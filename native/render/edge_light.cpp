// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/edge_light.h"

#include <algorithm>
#include <cmath>

#include "lighting/bounded_item.h"
#include "lighting/pooled_error.h"
#include "render/centre_light.h"

namespace penumbra {
namespace {

/// A whole sample's price without its rays to luminaires, and of one of these, in camera rays.
constexpr double kPriceOfSample = 3, kPriceOfRay = 0.3;

/// Of pixels that do without samples.
constexpr size_t kMostCentredSurfaces = 3;

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
  uint32_t edges[4], simple[4], some[4], anew[4], edge_count = 0, simple_count = 0, count = 0, anew_count = 0;
  uint32_t dimmed[4], dimmed_count = 0;
  for (uint32_t p : quad) {
    if (!frame_.edge[p] || !block_.in_core(p, margin)) continue;
    edges[edge_count++] = p;
    if (!pixels_[p].edge && may_be_centred(p)) simple[simple_count++] = p;
  }
  begin_centred({simple, simple_count});
  for (uint32_t p : std::span(edges, edge_count)) {
    const bool is_new = !pixels_[p].edge, sampled = pixels_[p].count > 0;
    if (!is_new && stays_centred(p)) {
      if (wants_split(p)) dimmed[dimmed_count++] = p;
      continue;
    }
    mark_unseen(p);
    if (is_new) begin_sights(p);
    const bool split = split_slots(p);
    if (!is_new && sampled && !split) continue;
    some[count++] = p;
    if (!sampled || split) anew[anew_count++] = p;
  }
  value_surfaces({dimmed, dimmed_count});
  first_level({some, count}, {anew, anew_count});
}

/// Light at the centre tells enough of a plain pixel, as far as neighbours' tells, too.
bool EdgeLight::may_be_centred(uint32_t p) const {
  const FilteredPixel& pixel = pixels_[p];
  return pixel.plain && pixel.count == 0 && !pixel.bent && slopes_around(p).bend <= kBendShare * tolerance_;
}

/// And so it does with what is known of the surfaces in it: they are even, and the centre's is among them.
bool EdgeLight::stays_centred(uint32_t p) const {
  const FilteredPixel& pixel = pixels_[p];
  if (!pixel.centred() || pixel.bent) return false;
  const std::vector<SeenSurface>& surfaces = pixel.edge->sights.surfaces();
  if (surfaces.size() > kMostCentredSurfaces) return false;
  for (const SeenSurface& surface : surfaces)
    if (surface.step > kBendShare * tolerance_) return false;
  const std::span<const Slot> slots = frame_.of_pixel(p);
  for (uint32_t s = 0; s < slots.size(); ++s) {
    const bool point = c_.luminaires[s / (frame_.glossy ? 2 : 1) % c_.luminaires.size()].is_point();
    if (slots[s].uncertain && (point || pixel.edge->centre_surface < 0)) return false;
  }
  return true;
}

/// A centred pixel in which other surfaces than the centre's were valued before penumbra was found there.
bool EdgeLight::wants_split(uint32_t p) const {
  return pixels_[p].edge->sights.surfaces().size() > 1 &&
         std::ranges::any_of(frame_.of_pixel(p),
                             [](const Slot& slot) { return slot.uncertain && !slot.split; });
}

/// Values surfaces of at most four centred pixels, in penumbra with many points of the luminaires each.
void EdgeLight::value_surfaces(std::span<const uint32_t> pixels) {
  for (uint32_t p : pixels) {
    if (!wants_split(p)) continue;
    for (Slot& slot : slots(p)) slot.split = slot.uncertain;
    for (SeenSurface& surface : pixels_[p].edge->sights.surfaces())
      if (!pixels_[p].edge->is_of_centre(surface)) surface.forget_values();
  }
  close_level(pixels);
}

/// The largest of a pixel's own and its neighbours', which may show the other surfaces in it; where nothing
/// tells the bend of those, nothing.
PlainSlopes EdgeLight::slopes_around(uint32_t p) const {
  const uint32_t x = p % block_.width, y = p / block_.width;
  PlainSlopes all = pixels_[p].slopes;
  for (uint32_t row = y - (y > 0); row <= std::min(y + 1, block_.height - 1); ++row) {
    for (uint32_t column = x - (x > 0); column <= std::min(x + 1, block_.width - 1); ++column) {
      const FilteredPixel& other = pixels_[row * block_.width + column];
      if (!other.plain || !std::isfinite(other.slopes.bend)) continue;
      all.slope = std::max(all.slope, other.slopes.slope);
      all.bend = std::max(all.bend, other.slopes.bend);
    }
  }
  return all;
}

/// 16 camera rays of at most four pixels, and samples of surfaces that the centre did not meet. Pixels that
/// turn out to need more have no state then.
void EdgeLight::begin_centred(std::span<const uint32_t> pixels) {
  constexpr uint32_t kHalf = kPacket / 2;
  for (uint32_t p : pixels) {
    begin_sights(p);
    pixels_[p].edge->slope = slopes_around(p).slope;
  }
  samples_.look_each(pixels, kFirstSamples, kHalf - kFirstSamples);
  for (uint32_t p : pixels) pixels_[p].edge->sights.mark_rays();
  samples_.look_each(pixels, kHalf, kHalf);
  uint32_t kept[4], count = 0;
  for (uint32_t p : pixels) {
    samples_.add_centre(p);
    if (stays_centred(p)) kept[count++] = p;
  }
  value_surfaces({kept, count});
  for (uint32_t p : pixels)
    if (pixels_[p].edge->sights.has_new_rays() || !stays_centred(p)) pixels_[p].edge = nullptr;
}

void EdgeLight::set_centre(uint32_t p, const PixelLight& light, double slope) {
  FilteredPixel& pixel = pixels_[p];
  SeenSurface& surface = pixel.edge->sights[uint32_t(pixel.edge->centre_surface)];
  pixel.edge->slope = std::max(pixel.edge->slope, slope);
  surface.forget_values();
  surface.add_value({light.radiance, pixel.alpha}, model_.display_scale);
  pixel.light_points = light.points;
  pixel.at_limit = light.at_limit;
  pixel.edge->centre_error = light.error - kKeptForSights * tolerance_;
  pixel.edge->close_level(pixel, slots(p), model_);
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
    pixels_[p].edge->power = LevelSums(pixels_[p], slots(p));
    pixels_[p].edge->sights.mark_samples();
  }
  samples_.trace_each(pixels, kFirstSamples, kHalf - kFirstSamples);
  for (uint32_t p : pixels) pixels_[p].edge->sights.mark_rays();
  samples_.look_each(pixels, kHalf, kHalf);
  close_level(pixels);
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
    return max_abs(slot.now.unshadowed) / pixel.samples() * model_.display_scale;
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

/// Which surfaces the first look's camera rays met.
void EdgeLight::begin_sights(uint32_t p) {
  FilteredPixel& pixel = pixels_[p];
  if (pixel.edge)
    *pixel.edge = {};
  else
    pixel.edge = &states_.emplace_back();
  PixelSights& sights = pixel.edge->sights;
  if (pixel.plain && !pixel.sees_more) return sights.begin(c_.geometry, pixel.centre, kFirstSamples);
  for (uint32_t i = 0; i < kFirstSamples; ++i) {
    const uint32_t k = sights.surface_of(c_.geometry, pixel.met[i]);
    sights.count_ray(k, i);
    if (pixel.count > 0) ++sights[k].samples.now;
  }
}

/// The samples, or the rays, or both, of at most four pixels are a level.
void EdgeLight::close_level(std::span<const uint32_t> pixels) {
  samples_.probe_surfaces(pixels);
  for (uint32_t p : pixels) pixels_[p].edge->close_level(pixels_[p], slots(p), model_);
}

/// One level more for a pixel: of samples, or of camera rays alone, whichever takes more from its variance
/// for the price. Returns whether there was one.
bool EdgeLight::advance(uint32_t p, const PixelVariance& variance) {
  FilteredPixel& pixel = pixels_[p];
  const bool sampled = pixel.count > 0;
  if (sampled ? split_slots(p) : !stays_centred(p) || variance.light > variance.shares) {
    if (!sampled) mark_unseen(p);
    first_level({&p, 1}, {&p, 1});
    return true;
  }
  const uint32_t rays = pixel.edge->sights.rays(), most = c_.settings.max_pixel_samples;
  const double price = kPriceOfSample + kPriceOfRay * double(pixel.light_points) / pixel.samples();
  const bool wants_rays = !sampled || variance.shares * price * pixel.count > variance.light * rays;
  if (wants_rays && next_level(rays) <= most) {
    for (uint32_t first = rays; first < next_level(rays); first += kPacket)
      samples_.look_each({&p, 1}, first, kPacket);
  } else if (!sampled) {
    return false;
  } else {
    const uint32_t target = next_level(pixel.count);
    if (target > most) return false;
    while (pixel.count < target)
      samples_.trace_each({&p, 1}, pixel.count, std::min(kPacket, target - pixel.count));
  }
  close_level({&p, 1});
  return true;
}

void EdgeLight::refine(std::span<const uint32_t> edges, const Rectangle& tile) {
  TileError errors(pixels_, frame_, tile, edges, tolerance_);
  std::vector<uint32_t> open(edges.begin(), edges.end());
  std::vector<std::pair<uint32_t, PixelVariance>> again;
  while (!open.empty()) {
    again.clear();
    errors.learn();
    for (uint32_t p : open) {
      FilteredPixel& pixel = pixels_[p];
      const PixelVariance variance = errors.of(p);
      const double error = std::sqrt(variance.shares + variance.light),
                   charged = pixel.charged / pixel.samples();
      const double centre = pixel.centred() ? pixel.edge->centre_error : 0;
      pixel.error = std::hypot(kPixelCalibration.report * error, centre) + charged;
      const double bound = kPixelCalibration.stop * error + charged,
                   tolerance = centre > 0 ? kLeftForSights * tolerance_ : tolerance_;
      if (bound > tolerance &&
          bound > tolerance * max_component(pixel.estimate(slots(p))) * model_.display_scale)
        again.push_back({p, variance});
    }
    open.clear();
    for (const auto& [p, variance] : again) {
      if (advance(p, variance))
        open.push_back(p);
      else
        pixels_[p].at_limit = true;
    }
  }
}

}  // namespace penumbra
