// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/tile.h"

#include <array>
#include <cmath>

namespace penumbra {
namespace {

constexpr uint32_t kTilePixels = kTile * kTile;

/// Sums over a pixel's primary rays.
struct PixelSums {
  PixelValues values;
  Vec3d light_variance;  // of the estimates of direct light
  Vec3d radiance_squares;
  const std::string* object = nullptr;  // seen by the first ray
  bool at_limit = false;
};

/// Primary sample s of every pixel of the tile: its place in the pixel, in pixels from the frame's corner.
void primary_rays(const TileContext& c, uint32_t x, uint32_t y, uint32_t s,
                  std::array<Ray, kTilePixels>& rays) {
  for (uint32_t i = 0; i < kTilePixels; ++i) {
    const uint32_t px = x + i % kTile, py = y + i / kTile;
    double dx = 0, dy = 0;
    if (c.settings.pixel_samples > 1) {
      alignas(64) float u[kPacket], v[kPacket];
      const uint64_t pixel = uint64_t(py) * c.settings.width + px;
      c.pixel_sampler.points({pixel, ~pixel}, s / kPacket * kPacket, kPacket, u, v);
      dx = c.filter.offset(u[s % kPacket]);
      dy = c.filter.offset(v[s % kPacket]);
    }
    rays[i] = c.camera.through(px + 0.5 + dx, py + 0.5 + dy);
  }
}

/// Light that comes back along a ray: direct light where it hits, and what mirrors show.
LightEstimate radiance_along(const TileContext& c, Ray ray, Hit hit, SurfacePoint surface, uint64_t stream,
                             TileTally& tally, LightTally& light) {
  const uint32_t depth = c.scene.has_mirrors() ? c.settings.mirror_depth : 0;
  LightEstimate sum;
  Vec3d throughput{1, 1, 1};
  for (uint32_t bounce = 0;; ++bounce) {
    const Material& material = c.scene.materials()[surface.material];
    const ShadingPoint point(surface, material, ray.direction);
    const LightEstimate direct = c.light.at(point, stream * (depth + 1) + bounce, light);
    sum.radiance += throughput * direct.radiance;
    sum.variance += throughput * throughput * direct.variance;

    throughput = throughput * material.mirror;
    if (bounce == depth || max_component(throughput) == 0) return sum;
    const Vec3d start = surface.position + surface.geometric_normal * surface.rounding;
    ray = {start, point.mirror_direction, 0, 1e30};
    c.geometry.intersect(&ray, 1, &hit);
    ++tally.mirror_rays;
    if (!hit.found()) {
      sum.radiance += throughput * c.scene.background().color;
      return sum;
    }
    surface = c.geometry.surface_point(ray, hit);
  }
}

void add_hit(const TileContext& c, const Ray& ray, const Hit& hit, uint64_t stream, bool first,
             TileTally& tally, PixelSums& pixel) {
  const SurfacePoint surface = c.geometry.surface_point(ray, hit);
  LightTally light;
  const LightEstimate estimate = radiance_along(c, ray, hit, surface, stream, tally, light);
  pixel.values.combined += estimate.radiance;
  pixel.values.alpha += 1;
  pixel.values.light_samples += double(light.light_points);
  pixel.light_variance += estimate.variance;
  pixel.radiance_squares += estimate.radiance * estimate.radiance;
  pixel.at_limit = pixel.at_limit || light.at_limit;
  if (first) {  // data passes are not filtered
    pixel.values.depth = surface.t;
    pixel.values.normal = surface.normal;
    pixel.values.position = c.geometry.normalization().world_point(surface.position);
    pixel.object = &c.geometry.name_of(hit);
  }
  tally.light += light;
}

void add_miss(const TileContext& c, bool first, PixelSums& pixel) {
  const Background& background = c.scene.background();
  if (!background.transparent) {
    pixel.values.combined += background.color;
    pixel.values.alpha += 1;
    pixel.radiance_squares += background.color * background.color;
  }
  if (first) pixel.values.depth = PixelValues::kNoDepth;
}

/// Averages the sums. Error: twice the standard error of independent samples, the largest of r, g, b, in
/// display units; for points more even than independent ones the true error is smaller.
PixelValues resolve(const RenderSettings& settings, const PixelSums& pixel) {
  const double n = settings.pixel_samples;
  PixelValues values = pixel.values;
  values.combined = values.combined / n;
  values.alpha /= n;
  Vec3d variance = pixel.light_variance;
  if (n > 1) {
    const Vec3d spread = pixel.radiance_squares / n - values.combined * values.combined;
    variance = spread / (n - 1);
  }
  values.error_estimate =
      2 * std::sqrt(std::max(max_component(variance), 0.0)) * std::exp2(settings.exposure);
  return values;
}

}  // namespace

void render_tile(const TileContext& c, uint32_t x, uint32_t y, TileTally& tally) {
  std::array<PixelSums, kTilePixels> pixels;
  std::array<Ray, kTilePixels> rays;
  std::array<Hit, kTilePixels> hits;
  const Rectangle& region = c.film.region();
  const auto in_region = [&](uint32_t px, uint32_t py) {
    return px >= region.x && py >= region.y && px < region.x + region.width && py < region.y + region.height;
  };

  for (uint32_t s = 0; s < c.settings.pixel_samples; ++s) {
    primary_rays(c, x, y, s, rays);
    for (uint32_t i = 0; i < kTilePixels; i += kPacket) c.geometry.intersect(&rays[i], 0xFFFF, &hits[i]);
    for (uint32_t i = 0; i < kTilePixels; ++i) {
      const uint32_t px = x + i % kTile, py = y + i / kTile;
      if (!in_region(px, py)) continue;
      ++tally.primary_rays;
      const uint64_t stream = (uint64_t(py) * c.settings.width + px) * c.settings.pixel_samples + s;
      if (hits[i].found())
        add_hit(c, rays[i], hits[i], stream, s == 0, tally, pixels[i]);
      else
        add_miss(c, s == 0, pixels[i]);
    }
  }

  for (uint32_t i = 0; i < kTilePixels; ++i) {
    const uint32_t px = x + i % kTile, py = y + i / kTile;
    if (!in_region(px, py)) continue;
    const PixelValues values = resolve(c.settings, pixels[i]);
    tally.pixels_at_limit += pixels[i].at_limit;
    if (c.film.write(px, py, values) && tally.non_finite_pixels++ == 0)
      tally.first_non_finite = "pixel " + std::to_string(px) + "," + std::to_string(py) + " (" +
                               (pixels[i].object ? *pixels[i].object : "background") + ")";
  }
}

}  // namespace penumbra
