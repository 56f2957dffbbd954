// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/filtered_samples.h"

#include <algorithm>
#include <cmath>

namespace penumbra {
namespace {

/// First samples whose unshadowed values leave a plane by more than this share of the tolerance want more
/// rays.
constexpr double kResidualShare = 0.7;

/// Calls function with samples [first, first + count) of as many of the pixels as fit a packet, and so on.
template <typename Function>
void for_packets(std::span<const uint32_t> pixels, uint32_t first, uint32_t count, Function function) {
  SampleRun runs[kPacket];
  for (size_t begin = 0; begin < pixels.size(); begin += kPacket / count) {
    const size_t n = std::min<size_t>(kPacket / count, pixels.size() - begin);
    for (size_t i = 0; i < n; ++i) runs[i] = {pixels[begin + i], first, count};
    function(std::span<const SampleRun>(runs, n));
  }
}

/// A ray told how much of a slot's luminaire is visible.
void see(Slot& slot, double visible) {
  slot.lit = slot.lit || visible > 0;
  slot.dark = slot.dark || visible < 1;
  slot.uncertain = slot.uncertain || (slot.lit && slot.dark);
}

}  // namespace

FilteredSamples::FilteredSamples(const RenderContext& context, FilteredFrame& frame,
                                 std::vector<FilteredPixel>& pixels, RenderTally& tally)
    : c_(context),
      frame_(frame),
      pixels_(pixels),
      display_scale_(std::exp2(context.settings.exposure)),
      tolerance_(context.settings.error_tolerance),
      packet_(context, frame, tally) {
  if (c_.extras.any()) parts_ = std::make_unique<FilteredParts>(c_, frame_, uint32_t(frame.edge.size()));
}

void FilteredSamples::trace_each(std::span<const uint32_t> pixels, uint32_t first, uint32_t count) {
  for_packets(pixels, first, count, [this](std::span<const SampleRun> runs) {
    packet_.trace(runs);
    add_light(runs);
  });
}

void FilteredSamples::look_each(std::span<const uint32_t> pixels, uint32_t first, uint32_t count) {
  for_packets(pixels, first, count, [this](std::span<const SampleRun> runs) {
    packet_.look(runs);
    uint32_t lane = 0;
    for (const SampleRun& run : runs) {
      PixelSights& sights = pixels_[run.pixel].edge->sights;
      for (uint32_t i = 0; i < run.count; ++i, ++lane) {
        const uint32_t index = run.first + i;
        sights.count_ray(sights.surface_of(c_.geometry, packet_.hits[lane]), index);
      }
    }
  });
}

void FilteredSamples::look_around(std::span<const uint32_t> pixels) {
  for_packets(pixels, 0, kFirstSamples, [this](std::span<const SampleRun> runs) {
    packet_.look(runs);
    uint32_t lane = 0;
    for (const SampleRun& run : runs) {
      FilteredPixel& pixel = pixels_[run.pixel];
      std::copy_n(packet_.hits + lane, kFirstSamples, pixel.met);
      bool more = false;
      for (const uint32_t end = lane + kFirstSamples; lane < end; ++lane)
        more = more || sees_more(pixel, lane);
      frame_.uncertain[run.pixel] = pixel.sees_more = more;
      if (pixel.plain) continue;
      pixel.begin();
      pixel.background_fitted = {};
      if (parts_) parts_->begin(run.pixel);
    }
  });
}

/// Does a ray see more than the centre? Facets of a flat surface make the pixel one that is not plain.
bool FilteredSamples::sees_more(FilteredPixel& pixel, uint32_t lane) const {
  const Primitive met(packet_.hits[lane]);
  if (!(met == pixel.centre)) {
    const Facet there = c_.geometry.facet_of(met), here = c_.geometry.facet_of(pixel.centre);
    if (!same_surface(there, here)) return true;
    pixel.plain = pixel.plain && step_between(there, here) <= kBendShare * tolerance_;
  }
  return packet_.lights_seen(lane) != pixel.first.lights;
}

void FilteredSamples::probe_surfaces(std::span<const uint32_t> pixels) {
  SampleRun runs[kPacket];
  SeenSurface* surfaces[kPacket];
  uint32_t count = 0;
  const auto trace = [&] {
    if (count == 0) return;
    packet_.trace({runs, count});
    for (uint32_t i = 0; i < count; ++i) {
      add_value(*surfaces[i], i);
      if (pixels_[runs[i].pixel].count == 0) note_visibility(runs[i].pixel, i);
    }
    count = 0;
  };
  for (uint32_t p : pixels) {
    const bool in_penumbra = std::ranges::any_of(slots(p), [](const Slot& slot) { return slot.uncertain; });
    for (SeenSurface& surface : pixels_[p].edge->sights.surfaces()) {
      const bool one_does = pixels_[p].count > 0 || pixels_[p].edge->is_of_centre(surface);
      const uint32_t wanted = one_does ? 1 : surface.wanted_values(in_penumbra);
      for (uint32_t k = surface.valued; k < wanted; ++k) {
        surfaces[count] = &surface;
        runs[count++] = {p, surface.indices[k], 1, true};
        if (count == kPacket) trace();
      }
    }
  }
  trace();
}

/// What a sample tells of a pixel's luminaires.
void FilteredSamples::note_visibility(uint32_t p, uint32_t lane) {
  for (const SlotColumns& column : packet_.contributions())
    if (column.arrives(lane) && column.traced(lane))
      see(slots(p)[column.slot], packet_.visible(column, lane));
}

void FilteredSamples::add_centre(uint32_t p) {
  const FilteredPixel& pixel = pixels_[p];
  PixelSights& sights = pixel.edge->sights;
  const Facet facet = c_.geometry.facet_of(pixel.centre);
  for (uint32_t k = 0; k < sights.surfaces().size(); ++k) {
    if (!same_surface(sights[k].facet, facet)) continue;
    pixel.edge->centre_surface = int32_t(k);
    return sights[k].add_value({pixel.fitted(slots(p)), pixel.alpha}, display_scale_);
  }
}

void FilteredSamples::forget(uint32_t p) {
  pixels_[p].begin();
  for (Slot& slot : slots(p)) slot.now = {}, slot.rays = 0;
  if (parts_) parts_->begin(p);
}

/// Adds what the packet found to its pixels' sums.
void FilteredSamples::add_light(std::span<const SampleRun> runs) {
  for (const SlotColumns& column : packet_.contributions()) {
    uint32_t lane = 0;
    for (const SampleRun& run : runs) {
      add_to(slots(run.pixel)[column.slot], column, lane, run.count);
      lane += run.count;
    }
  }
  uint32_t lane = 0;
  for (const SampleRun& run : runs) {
    FilteredPixel& pixel = pixels_[run.pixel];
    if (run.first == 0 && !pixel.edge) {
      pixel.first = packet_.ends[lane].first;
      std::copy_n(packet_.hits + lane, kFirstSamples, pixel.met);
      fit_plane(run, lane);
    }
    for (uint32_t i = 0; i < run.count; ++i, ++lane) {
      const PathEnd& end = packet_.ends[lane];
      pixel.background += end.background;
      pixel.alpha += end.alpha;
      pixel.charged += packet_.charge[lane];
      pixel.light_points += packet_.rays_of[lane];
      if (pixel.edge) add_sight(pixel, lane, run.first + i);
    }
    pixel.count = run.first + run.count;
  }
  if (parts_) parts_->add(packet_, runs);
}

/// Adds `count` lanes to one pixel's slot.
void FilteredSamples::add_to(Slot& slot, const SlotColumns& column, uint32_t lane, uint32_t count) const {
  for (const uint32_t end = lane + count; lane < end; ++lane) {
    if (!column.arrives(lane)) continue;
    const Vec3d light = column.unshadowed.get(lane);
    slot.now.unshadowed += light;
    if (!column.traced(lane)) continue;
    const double visible = packet_.visible(column, lane);
    ++slot.rays;
    slot.now.add_visibility(light, column.weight[lane], visible);
    see(slot, visible);
  }
}

/// A whole sample at an edge belongs to the surface that it meets.
void FilteredSamples::add_sight(FilteredPixel& pixel, uint32_t lane, uint32_t index) const {
  PixelSights& sights = pixel.edge->sights;
  const uint32_t k = sights.surface_of(c_.geometry, packet_.hits[lane]);
  SeenSurface& surface = sights[k];
  sights.count_ray(k, index);
  ++surface.samples.now;
  add_value(surface, lane);
}

void FilteredSamples::add_value(SeenSurface& surface, uint32_t lane) const {
  surface.add_value({packet_.value(lane), packet_.ends[lane].alpha}, display_scale_);
  if (parts_) parts_->add_value(surface, packet_, lane);
}

/// The first samples' plane: unshadowed values at the pixel's centre, and how far they are from being a
/// plane. `lane`: the first of the run.
void FilteredSamples::fit_plane(const SampleRun& run, uint32_t lane) {
  FilteredPixel& pixel = pixels_[run.pixel];
  const PlaneFit fit(packet_.dx + lane, packet_.dy + lane);
  const PathEnd* ends = packet_.ends + lane;
  Vec3d residual;
  bool uncertain = false;
  for (uint32_t i = 0; i < kFirstSamples; ++i) {
    pixel.background_fitted += ends[i].background * fit.h[i];
    residual += ends[i].background * fit.r[i];
    uncertain = uncertain || ends[i].first.object != ends[0].first.object ||
                ends[i].first.lights != ends[0].first.lights;
  }
  for (const SlotColumns& column : packet_.contributions()) {
    Vec3d& fitted = slots(run.pixel)[column.slot].fitted;
    for (uint32_t i = 0; i < kFirstSamples; ++i) {
      if (!column.arrives(lane + i)) continue;
      const Vec3d unshadowed = column.unshadowed.get(lane + i);
      fitted += unshadowed * fit.h[i];
      residual += unshadowed * fit.r[i];
    }
  }
  frame_.uncertain[run.pixel] = uncertain || max_abs(residual) * display_scale_ > kResidualShare * tolerance_;
}

}  // namespace penumbra
