// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/centre_light.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "render/filtered_parts.h"

namespace penumbra {
namespace {

/// Share of the tolerance that taking the centre for the filtered pixel may cost.
constexpr double kFilterShare = 0.3;

/// Share of the tolerance that dim luminaires may be charged for being dropped.
constexpr double kDropShare = 0.125;

/// What noise of 16 points adds to a second difference, as a share of the unshadowed value: three standard
/// deviations, sqrt(6) for the difference times 16^-3/4 / 2 for each value.
constexpr double kFirstNoise = 3 * 2.45 * 0.125 * 0.5;

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

/// Display value of one luminaire's light in one bounce.
double CentreLight::value(uint32_t p, uint32_t pair) const {
  const uint32_t i = item_of(p, pair);
  if (i != kNone) return items_[i].display(items_[i].sums);
  double sum = 0;
  for (uint32_t lobe = 0; lobe < lobes_; ++lobe)
    sum += max_abs(frame_.of_pixel(p)[pair * lobes_ + lobe].fitted_radiance());
  return sum * settings_.display_scale;
}

double CentreLight::slope(uint32_t p) const {
  double slope = -1;
  const auto sum = [this](uint32_t q) {
    double all = 0;
    for (uint32_t pair = 0; pair < pairs_; ++pair) all += value(q, pair);
    return all;
  };
  const auto knows_all = [this](uint32_t q) {
    for (uint32_t pair = 0; pair < pairs_; ++pair)
      if (!knows(q, pair)) return false;
    return true;
  };
  const double here = sum(p);
  const uint32_t at[2] = {frame_.area.x + p % block_.width, frame_.area.y + p / block_.width};
  for (int axis = 0; axis < 2; ++axis) {
    const uint32_t stride = axis == 0 ? 1 : block_.width;
    if (at[axis] % kTile > 0 && continues(p - stride, axis) && knows_all(p - stride))
      slope = std::max(slope, std::abs(sum(p - stride) - here));
    if ((at[axis] + 1) % kTile > 0 && p + stride < block_.pixels() && continues(p, axis) &&
        knows_all(p + stride))
      slope = std::max(slope, std::abs(sum(p + stride) - here));
  }
  return slope < 0 ? here : slope;
}

/// Of a pixel's centre; not where there are samples instead.
bool CentreLight::knows(uint32_t p, uint32_t pair) const {
  if (!pixels_[p].plain) return !frame_.edge[p];
  return !uncertain(p, pair) || item_of(p, pair) != kNone;
}

/// The next pixel along an axis shows the same surface.
bool CentreLight::continues(uint32_t p, int axis) const {
  const uint32_t q = p + (axis == 0 ? 1 : block_.width);
  if (pixels_[p].plain && pixels_[q].plain) return pixels_[q].joined & kJoinedTo[axis];
  return !frame_.edge[p] && !frame_.edge[q];
}

/// How far the filtered value may be from the centre's: half the filter's second moment times the second
/// differences along rows and columns, for whole pixels of the tile. At its edge the one further in and its
/// change stand for it; where too few neighbours are known, first differences do.
double CentreLight::filter_error(uint32_t p, uint32_t pair, const Rectangle& tile) const {
  const uint32_t at[2] = {p % block_.width - tile.x, p / block_.width - tile.y},
                 size[2] = {tile.width, tile.height}, stride[2] = {1, block_.width};
  const double here = value(p, pair);
  double sum = 0;
  for (int axis = 0; axis < 2; ++axis) {
    // Values from two pixels before to three behind, on the same surface; those outside the tile are not
    // known.
    const auto known = [&](int d) {
      const int i = int(at[axis]) + d;
      if (i < 0 || i >= int(size[axis])) return false;
      for (int k = std::min(d, 0); k < std::max(d, 0); ++k)
        if (!continues(p + uint32_t(k) * stride[axis], axis)) return false;
      return knows(p + uint32_t(d) * stride[axis], pair);
    };
    const auto at_distance = [&](int d) { return value(p + uint32_t(d) * stride[axis], pair); };
    const auto bend = [&](int d) { return at_distance(d - 1) - 2 * at_distance(d) + at_distance(d + 1); };
    if (known(-1) && known(1)) {
      sum += std::abs(bend(0));
    } else if (known(1) && known(2) && known(3)) {
      sum += std::abs(bend(1)) + std::abs(bend(2) - bend(1));
    } else if (known(-1) && known(-2) && known(-3)) {
      sum += std::abs(bend(-1)) + std::abs(bend(-2) - bend(-1));
    } else if (known(1) || known(-1)) {
      const double step = std::abs(at_distance(known(1) ? 1 : -1) - here);
      sum += std::max(2 * step, settings_.tolerance);
    } else {
      return size[axis] == 1 ? 0 : 1e30;  // a picture of one line
    }
  }
  return 0.5 * c_.filter.variance() * sum;
}

/// Keeps the pixels whose filtered value is their centre's, and makes edges of the others.
std::vector<uint32_t> CentreLight::keep_smooth(std::span<const uint32_t> pixels, const Rectangle& tile,
                                               bool first) {
  std::vector<uint32_t> kept, bent;
  for (uint32_t p : pixels) {
    double error = 0;
    for (uint32_t pair = 0; pair < pairs_; ++pair) {
      if (!uncertain(p, pair)) continue;
      const uint32_t i = item_of(p, pair);
      const double noise = first && i != kNone ? kFirstNoise * items_[i].size() * c_.filter.variance() : 0;
      error += std::max(filter_error(p, pair, tile) - noise, 0.0);
    }
    (error > kFilterShare * settings_.tolerance ? bent : kept).push_back(p);
    if (!first) light_[p].error = std::hypot(light_[p].error, error);
  }
  for (uint32_t p : bent) frame_.edge[p] = pixels_[p].bent = true;
  return kept;
}

void CentreLight::refine(std::span<const uint32_t> pixels, const Rectangle& tile) {
  if (pixels.empty()) return;
  light_.resize(block_.pixels());
  const std::vector<uint32_t> smooth = keep_smooth(pixels, tile, true);
  std::vector<BoundedItem*> items;
  for (uint32_t p : smooth) {
    const FilteredPixel& pixel = pixels_[p];
    light_[p] = {};
    light_[p].radiance = pixel.fitted(frame_.of_pixel(p));
    light_[p].error =
        pixel.charged / pixel.samples() + (pixel.centred() ? kKeptForSights * settings_.tolerance : 0);
    light_[p].points = pixel.light_points;
    for (uint32_t pair = 0; pair < pairs_; ++pair)
      if (item_of(p, pair) != kNone) items.push_back(&items_[item_of(p, pair)]);
  }
  TileRefiner(sampler_, points_, block_, settings_).refine(items, light_, tally_.light);
  for (const BoundedItem* item : items) light_[points_[item->point].pixel].points += item->used();
  keep_smooth(smooth, tile, false);
}

}  // namespace penumbra
