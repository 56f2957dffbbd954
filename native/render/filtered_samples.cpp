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
        sights.count_ray(sights.surface_of(c_.geometry, packet_.hits[lane], index), index);
      }
    }
  });
}

void FilteredSamples::probe_surfaces(uint32_t p) {
  PixelSights& sights = pixels_[p].edge->sights;
  for (uint32_t k = 0; k < sights.surfaces().size(); ++k) {
    if (sights[k].valued > 0) continue;
    const SampleRun run{p, sights[k].index, 1};
    packet_.trace({&run, 1});
    add_value(sights[k], 0);
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
    slot.now.unshadowed += column.unshadowed.get(lane);
    if (!column.traced(lane)) continue;
    const double visible = packet_.visible(column, lane);
    ++slot.rays;
    slot.now.w += column.weight[lane];
    slot.now.wv += visible * column.weight[lane];
    slot.lit = slot.lit || visible > 0;
    slot.dark = slot.dark || visible < 1;
    slot.uncertain = slot.uncertain || (slot.lit && slot.dark);
  }
}

/// A whole sample at an edge belongs to the surface that it meets.
void FilteredSamples::add_sight(FilteredPixel& pixel, uint32_t lane, uint32_t index) const {
  PixelSights& sights = pixel.edge->sights;
  const uint32_t k = sights.surface_of(c_.geometry, packet_.hits[lane], index);
  SeenSurface& surface = sights[k];
  sights.count_ray(k, index);
  ++surface.samples.now;
  add_value(surface, lane);
}

void FilteredSamples::add_value(SeenSurface& surface, uint32_t lane) const {
  const Vec3d value = packet_.value(lane);
  const double x = max_component(value) * display_scale_;
  ++surface.valued;
  surface.value += value;
  surface.alpha += packet_.ends[lane].alpha;
  surface.x += x;
  surface.xx += x * x;
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
