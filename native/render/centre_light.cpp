// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/centre_light.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "render/filtered_parts.h"

namespace penumbra {
namespace {

/// Share of the tolerance that dim luminaires may be charged for being dropped.
constexpr double kDropShare = 0.125;

}  // namespace

CentreLight::CentreLight(const RenderContext& context, const Block& block, FilteredFrame& frame,
                         std::vector<FilteredPixel>& pixels, RenderTally& tally, FilteredParts* parts)
    : c_(context),
      block_(block),
      frame_(frame),
      pixels_(pixels),
      tally_(tally),
      parts_(parts),
      settings_(context.settings.bounded_settings(context.geometry)),
      luminaires_(uint32_t(context.luminaires.size())),
      lobes_(frame.glossy ? 2 : 1),
      pairs_(luminaires_ * context.paths.length()),
      first_point_(block.pixels(), kNone),
      path_length_(block.pixels(), 0),
      item_of_(size_t(block.pixels()) * pairs_, kNone),
      weight_(context.filter.variance() / 2),
      kink_share_((context.filter.mean_distance() / context.filter.variance() - 1) / 2),
      sampler_(context.geometry, context.luminaires, context.light_sampler, points_, settings_),
      first_look_(sampler_, block, context.luminaires, points_, settings_, kDropShare, context.memory) {
  points_.reserve(block.pixels());
}

void CentreLight::look(std::span<const PixelPlace> places) {
  Ray rays[kPacket];
  HitColumns found;
  trace(places, rays, found);
  for (uint32_t i = 0; i < places.size(); ++i) {
    const uint32_t p = pixel_at(places[i], frame_.area);
    if (p == kOutside) continue;
    FilteredPixel& pixel = pixels_[p];
    ++tally_.primary_rays;
    if (!c_.paths.is_plain(found.hits[i])) continue;
    const PathRecord record = parts_ ? parts_->record_of_centre(p) : PathRecord{};
    const PathEnd end = follow(found, i, p, parts_ ? &record : nullptr);
    pixel.plain = true;
    pixel.centre = found.hits[i];
    pixel.material = found.hits[i].found() ? c_.geometry.material_of(found.hits[i]) : 0;
    pixel.first = end.first;
    pixel.background = pixel.background_fitted = pixel.centre_light = end.background;
    pixel.alpha = end.alpha;
  }
}

void CentreLight::look_at_lights(bool all_found) {
  for (std::span<const LookedItem> items; !(items = first_look_.next(all_found, tally_.light)).empty();) {
    for (const LookedItem& item : items) {
      FilteredPixel& pixel = pixels_[item.pixel];
      if (!pixel.plain) continue;
      Slot& slot = frame_.of_pixel(item.pixel)[item.luminaire * lobes_];
      slot.now.unshadowed = slot.fitted = item.diffuse;
      slot.lit = item.first_lit != 0;
      slot.dark = item.first_dark != 0;
      slot.uncertain = slot.lit && slot.dark;
      slot.first_lit = item.first_lit;
      slot.first_dark = item.first_dark;
      const bool one = c_.luminaires[item.luminaire].is_point();
      slot.rays = one ? kFirstLook : uint32_t(std::popcount(uint8_t(item.first_lit | item.first_dark)));
      pixel.light_points += one ? 1 : kFirstLook;
      pixel.centre_light += item.diffuse;
    }
  }
  if (all_found) add_dropped_items();
}

/// A pixel sees of the dropped items, which come pixel by pixel, what it sees of the others.
void CentreLight::add_dropped_items() {
  uint32_t counted = kNone, lit = 0, dark = 0;
  for (const LookedItem& item : first_look_.dropped()) {
    if (!pixels_[item.pixel].plain) continue;
    if (item.pixel != counted) {
      counted = item.pixel, lit = dark = 0;
      for (const Slot& slot : frame_.of_pixel(item.pixel)) {
        lit += uint32_t(std::popcount(slot.first_lit));
        dark += uint32_t(std::popcount(slot.first_dark));
      }
    }
    const double share = expected_share(lit, dark);
    FilteredPixel& pixel = pixels_[item.pixel];
    pixel.background += item.diffuse * share;
    pixel.background_fitted += item.diffuse * share;
    pixel.centre_light += item.diffuse;
    if (parts_ && !parts_->of_centre(item.pixel).empty())
      add_light(parts_->of_centre(item.pixel), c_.luminaires[item.luminaire], points_[item.point],
                {item.diffuse * share, item.diffuse}, {});
    pixel.charged += item.size() * share_deviation(share);
  }
}

bool CentreLight::uncertain(uint32_t p, uint32_t pair) const {
  const Slot* slot = &frame_.of_pixel(p)[pair * lobes_];
  return slot[0].uncertain || slot[lobes_ - 1].uncertain;
}

void CentreLight::start(std::span<const uint32_t> pixels) {
  uint32_t untraced[kPacket], count = 0;
  for (uint32_t p : pixels)
    if (first_point_[p] == kNone) untraced[count++] = p;
  if (count) trace_samples({untraced, count});
  for (uint32_t p : pixels)
    if (!frame_.edge[p] || pixels_[p].centred()) add_items(p);
}

/// Rays through centres.
void CentreLight::trace(std::span<const PixelPlace> places, Ray* rays, HitColumns& found) const {
  for (size_t i = 0; i < places.size(); ++i)
    rays[i] = c_.camera.through(places[i].x + 0.5, places[i].y + 0.5);
  c_.geometry.find_surfaces(rays, uint32_t(places.size()), found);
}

/// The surface points that a pixel's centre sees.
PathEnd CentreLight::follow(const HitColumns& found, uint32_t ray, uint32_t p, const PathRecord* record) {
  const uint64_t stream =
      uint64_t(frame_.area.y + p / block_.width) * c_.settings.width + frame_.area.x + p % block_.width;
  first_point_[p] = uint32_t(points_.size());
  PathEnd end;
  c_.paths.follow(found, ray, p, stream, points_, tally_.mirror_rays, end, record);
  path_length_[p] = uint32_t(points_.size()) - first_point_[p];
  return end;
}

void CentreLight::trace_samples(std::span<const uint32_t> pixels) {
  PixelPlace places[kPacket];
  Ray rays[kPacket];
  HitColumns found;
  for (size_t i = 0; i < pixels.size(); ++i)
    places[i] = {frame_.area.x + pixels[i] % block_.width, frame_.area.y + pixels[i] / block_.width};
  trace({places, pixels.size()}, rays, found);
  tally_.primary_rays += pixels.size();
  for (size_t i = 0; i < pixels.size(); ++i) {
    const PathEnd end = follow(found, uint32_t(i), pixels[i], nullptr);
    if (edge_between(end.first, pixels_[pixels[i]].first)) frame_.edge[pixels[i]] = 1;
  }
}

void CentreLight::add_items(uint32_t p) {
  for (uint32_t pair = 0; pair < path_length_[p] * luminaires_; ++pair) {
    if (!uncertain(p, pair) || item_of(p, pair) != kNone) continue;
    const uint32_t point = first_point_[p] + pair / luminaires_, l = pair % luminaires_;
    const double form_factor = c_.luminaires[l].form_factor(points_[point].surface);
    if (form_factor <= 0) continue;
    item_of(p, pair) = uint32_t(items_.size());
    items_.push_back(sampler_.make(point, l, form_factor));
    const Slot& slot = frame_.of_pixel(p)[pair * lobes_];
    items_.back().first_lit = slot.first_lit;
    items_.back().first_dark = slot.first_dark;
    items_.back().looked = slot.first_lit || slot.first_dark;
    sampler_.advance(items_.back(), next_level(0), tally_.light);
  }
}

bool CentreLight::mixed(uint32_t p, uint32_t slot) const {
  const uint32_t i = item_of(p, slot / lobes_);
  return i != kNone && items_[i].lit > 0 && items_[i].lit < items_[i].facing;
}

void CentreLight::add_parts(uint32_t p, std::span<Vec3d> parts) const {
  for (uint32_t pair = 0; pair < pairs_; ++pair) {
    if (item_of(p, pair) == kNone) continue;
    const BoundedItem& item = items_[item_of(p, pair)];
    add_light(parts, c_.luminaires[item.luminaire], points_[item.point],
              {item.diffuse_radiance(), item.diffuse}, {item.glossy_radiance(), item.phong});
    add_light(parts, c_.luminaires[item.luminaire], kDiffuseLight, {filter_change(p, pair), {}}, {});
  }
}

void CentreLight::tell(PixelTrace& trace) const {
  for (uint32_t pair = 0; pair < pairs_; ++pair) {
    if (item_of(trace.pixel, pair) == kNone) continue;
    const BoundedItem& item = items_[item_of(trace.pixel, pair)];
    trace.decisions.push_back({pair / luminaires_, item.luminaire,
                               "in penumbra, seen from the pixel's centre", item.count, item.radiance()});
  }
}

}  // namespace penumbra
