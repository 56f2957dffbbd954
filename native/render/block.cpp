// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/block.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace penumbra {
namespace {

/// What a pixel's primary rays see beside its surface points. Kept for every pixel, and written before it is
/// read: without zeroing it first.
struct PixelView {
  PixelView() {}
  Vec3d background;  // of the current one, in mirrors too
  double alpha;      // of the current one
  FirstSight first;  // of the first one: data passes are not filtered
};

/// Of a pixel's primary rays.
struct PixelSums {
  Vec3d radiance, squares;
  double alpha = 0, points = 0;
  double error = 0;  // of the light, one primary ray
  bool at_limit = false;

  void add(const PixelLight& light, const PixelView& view) {
    const Vec3d sum = light.radiance + view.background;
    radiance += sum;
    squares += sum * sum;
    alpha += view.alpha;
    points += double(light.points);
    error = light.error;
    at_limit = at_limit || light.at_limit;
  }
};

class BlockRenderer {
 public:
  BlockRenderer(const RenderContext& context, const Rectangle& core, RenderTally& tally)
      : c_(context),
        tally_(tally),
        area_(with_halo(core, context.lighting.halo(), context.settings)),
        block_(block_of(core, area_, context.settings)),
        views_(context.memory),
        sums_(context.memory),
        points_(context.memory) {
    views_.resize(block_.pixels());
    if (c_.settings.pixel_samples > 1) sums_.resize(block_.pixels());
    points_.reserve(block_.pixels());
    if (c_.extras.want_parts()) parts_.emplace(block_.pixels(), c_.extras.light_groups());
    if (c_.extras.want_mattes()) mattes_.resize(block_.pixels());
    if (c_.extras.any()) seen_.resize(block_.pixels());
    if (tally.light.trace) aim(*tally.light.trace, area_);
  }

  void run() {
    for (uint32_t s = 0; s < c_.settings.pixel_samples; ++s) {
      Reused<PixelLight> light(c_.memory, block_.pixels());
      const auto lighting = c_.lighting.begin(
          {block_, c_.luminaires, points_, light, tally_.light, parts_ ? &*parts_ : nullptr, c_.memory});
      points_.clear();
      trace(s, *lighting);
      lighting->finish();
      for (uint32_t y = 0; y < block_.core_height; ++y)
        for (uint32_t x = 0; x < block_.core_width; ++x)
          add_light(light, block_.core_x + x, block_.core_y + y, s + 1 == c_.settings.pixel_samples);
    }
  }

 private:
  Ray primary_ray(uint32_t x, uint32_t y, uint32_t s) const;
  void trace(uint32_t s, BlockLighting& lighting);
  void follow(const HitColumns& found, uint32_t ray, uint32_t pixel, uint32_t s);
  PathRecord record_of(uint32_t pixel, bool first);
  void add_light(const std::vector<PixelLight>& light, uint32_t x, uint32_t y, bool last);
  PixelValues resolve(const PixelSums& sums, const PixelView& view) const;
  void write(uint32_t pixel, uint32_t x, uint32_t y, const PixelSums& sums);
  bool write_extras(uint32_t pixel, uint32_t x, uint32_t y);

  const RenderContext& c_;
  RenderTally& tally_;
  Rectangle area_;  // of the block with its halo, full-frame pixels
  Block block_;
  Reused<PixelView> views_;  // by pixel
  Reused<PixelSums> sums_;   // by pixel, if there are several samples
  Reused<LitPoint> points_;  // seen by the current sample
  // Only where passes want them, by pixel: sums over the samples, and what the first one met.
  std::optional<LightParts> parts_;
  std::vector<std::vector<MatteHit>> mattes_;
  std::vector<SeenObject> seen_;
};

/// Sample s of a pixel: through its centre if it is the only one, else distributed as the pixel filter and
/// what else spreads rays.
Ray BlockRenderer::primary_ray(uint32_t x, uint32_t y, uint32_t s) const {
  double dx = 0, dy = 0;
  if (c_.settings.pixel_samples > 1 && c_.pixel_rays.spread()) {
    Ray ray;
    const PixelSamples one{x, y, {uint64_t(y) * c_.settings.width + x, s, 1}};
    c_.pixel_rays.make({&one, 1}, &ray, &dx, &dy);
    return ray;
  }
  if (c_.settings.pixel_samples > 1) {
    alignas(64) float u[kPacket], v[kPacket];
    const uint64_t pixel = uint64_t(y) * c_.settings.width + x;
    c_.pixel_sampler.points({pixel, ~pixel}, s / kPacket * kPacket, kPacket, u, v);
    c_.filter.offsets(u + s % kPacket, 1, &dx);
    c_.filter.offsets(v + s % kPacket, 1, &dy);
  }
  return c_.camera.through(x + 0.5 + dx, y + 0.5 + dy);
}

/// Finds the surface points that sample s of each pixel sees, quad by quad of the frame.
void BlockRenderer::trace(uint32_t s, BlockLighting& lighting) {
  Ray rays[kPacket];
  HitColumns found;
  for_packets_of_pixels(area_, [&](std::span<const PixelPlace> places) {
    for (uint32_t i = 0; i < kPacket; ++i) rays[i] = primary_ray(places[i].x, places[i].y, s);
    tally_.light.stop_if_cancelled();
    c_.geometry.find_surfaces(rays, kPacket, found);
    for (uint32_t i = 0; i < kPacket; ++i) {
      const uint32_t pixel = pixel_at(places[i], area_);
      if (pixel == kOutside) continue;
      ++tally_.primary_rays;
      follow(found, i, pixel, s);
    }
    lighting.look();
  });
}

/// The points that one primary ray sees; its data passes, if it is the pixel's first.
void BlockRenderer::follow(const HitColumns& found, uint32_t ray, uint32_t pixel, uint32_t s) {
  const uint64_t frame_pixel =
      uint64_t(area_.y + pixel / block_.width) * c_.settings.width + area_.x + pixel % block_.width;
  const PathRecord record = record_of(pixel, s == 0);
  PathEnd end;
  c_.paths.follow(found, ray, pixel, frame_pixel * c_.settings.pixel_samples + s, points_, tally_.mirror_rays,
                  end, c_.extras.any() ? &record : nullptr);
  PixelView& view = views_[pixel];
  view.background = end.background;
  view.alpha = end.alpha;
  if (s == 0) view.first = end.first;
}

PathRecord BlockRenderer::record_of(uint32_t pixel, bool first) {
  PathRecord record{.mist = &c_.settings.mist};
  if (parts_) record.parts = parts_->of(pixel);
  if (!mattes_.empty()) record.mattes = &mattes_[pixel];
  if (first && !seen_.empty()) record.seen = &seen_[pixel];
  return record;
}

/// Of pixel (x, y) of the block; writes it after its last sample.
void BlockRenderer::add_light(const std::vector<PixelLight>& light, uint32_t x, uint32_t y, bool last) {
  const uint32_t pixel = y * block_.width + x;
  PixelSums only;
  PixelSums& sums = sums_.empty() ? only : sums_[pixel];
  sums.add(light[pixel], views_[pixel]);
  if (last) write(pixel, area_.x + x, area_.y + y, sums);
}

/// Averages the sums. The error of several primary rays: twice the standard error that their spread tells.
PixelValues BlockRenderer::resolve(const PixelSums& sums, const PixelView& view) const {
  const double n = c_.settings.pixel_samples;
  PixelValues values;
  values.combined = sums.radiance / n;
  values.alpha = sums.alpha / n;
  set_data_passes(values, view.first, c_.geometry.normalization());
  values.light_samples = sums.points;
  values.error_estimate = sums.error;
  if (n > 1) {
    const Vec3d variance = (sums.squares / n - values.combined * values.combined) / (n - 1);
    values.error_estimate =
        2 * std::sqrt(std::max(max_component(variance), 0.0)) * std::exp2(c_.settings.exposure);
  }
  return values;
}

bool BlockRenderer::write_extras(uint32_t pixel, uint32_t x, uint32_t y) {
  const double n = c_.settings.pixel_samples;
  PixelParts extra{.parts = {}, .mattes = {}, .samples = n};
  if (parts_) {
    for (Vec3d& part : parts_->of(pixel)) part = part / n;
    extra.parts = parts_->of(pixel);
  }
  if (!mattes_.empty()) extra.mattes = mattes_[pixel];
  return c_.extras.write(x, y, seen_[pixel], extra);
}

void BlockRenderer::write(uint32_t pixel, uint32_t x, uint32_t y, const PixelSums& sums) {
  const Rectangle& region = c_.film.region();
  if (x - region.x >= region.width || y - region.y >= region.height) return;
  tally_.pixels_at_limit += sums.at_limit;
  const bool broken = c_.film.write(x, y, resolve(sums, views_[pixel])),
             extra_broken = c_.extras.any() && write_extras(pixel, x, y);
  if ((broken || extra_broken) && tally_.non_finite_pixels++ == 0)
    tally_.first_non_finite = pixel_name(x, y, views_[pixel].first.object);
}

}  // namespace

RenderTally::RenderTally(const Counts& c, std::string first_non_finite_pixel)
    : light{c[0], c[1], c[2], c[8], c[3], nullptr, nullptr},
      primary_rays(c[4]),
      mirror_rays(c[5]),
      pixels_at_limit(c[6]),
      non_finite_pixels(c[7]),
      first_non_finite(std::move(first_non_finite_pixel)) {}

RenderTally::Counts RenderTally::counts() const {
  return {light.light_points,        light.shadow_rays, light.shadow_rays_beyond_stop,
          light.decided_without_ray, primary_rays,      mirror_rays,
          pixels_at_limit,           non_finite_pixels, light.light_lines};
}

RenderTally& RenderTally::operator+=(const RenderTally& o) {
  light += o.light;
  primary_rays += o.primary_rays;
  mirror_rays += o.mirror_rays;
  pixels_at_limit += o.pixels_at_limit;
  non_finite_pixels += o.non_finite_pixels;
  if (first_non_finite.empty()) first_non_finite = o.first_non_finite;
  return *this;
}

Rectangle with_halo(const Rectangle& core, uint32_t halo, const RenderSettings& settings) {
  Rectangle area;
  area.x = core.x - std::min(core.x, halo);
  area.y = core.y - std::min(core.y, halo);
  area.width = std::min(core.x + core.width + halo, settings.width) - area.x;
  area.height = std::min(core.y + core.height + halo, settings.height) - area.y;
  return area;
}

Block block_of(const Rectangle& core, const Rectangle& area, const RenderSettings& settings) {
  return {area.width,
          area.height,
          core.x - area.x,
          core.y - area.y,
          std::min(core.x + core.width, settings.width) - core.x,
          std::min(core.y + core.height, settings.height) - core.y};
}

void aim(PixelTrace& trace, const Rectangle& area) {
  trace.pixel = (trace.y - area.y) * area.width + trace.x - area.x;
}

std::string pixel_name(uint32_t x, uint32_t y, const std::string* object) {
  return "pixel " + std::to_string(x) + "," + std::to_string(y) + " (" + (object ? *object : "background") +
         ")";
}

void set_data_passes(PixelValues& values, const FirstSight& first, const Normalization& normalization) {
  values.depth = first.hit ? first.t : PixelValues::kNoDepth;
  values.normal = first.hit ? Vec3d(first.normal) : Vec3d{};
  values.position = first.hit ? normalization.world_point(first.position) : Vec3d{};
}

void render_block(const RenderContext& context, const Rectangle& core, RenderTally& tally) {
  BlockRenderer(context, core, tally).run();
}

}  // namespace penumbra
