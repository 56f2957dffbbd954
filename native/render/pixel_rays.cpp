// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/pixel_rays.h"

#include "sampling/sampler.h"

namespace penumbra {

void PixelRays::make(std::span<const PixelSamples> pixels, Ray* rays, double* dx, double* dy) const {
  SampleRange ranges[kPacket];
  for (size_t i = 0; i < pixels.size(); ++i) ranges[i] = pixels[i].range;
  const std::span<const SampleRange> all(ranges, pixels.size());
  alignas(64) float u[kPacket], v[kPacket], lens_u[kPacket] = {}, lens_v[kPacket] = {}, time[kPacket] = {};
  sampler_.pixel(all, u, v);
  if (camera_.has_lens()) sampler_.lens(all, lens_u, lens_v);
  if (moves_) sampler_.time(all, time);
  uint32_t count = 0;
  for (const SampleRange& range : all) count += range.count;
  filter_.offsets(u, count, dx);
  filter_.offsets(v, count, dy);
  uint32_t i = 0;
  for (const PixelSamples& pixel : pixels) {
    for (const uint32_t end = i + pixel.range.count; i < end; ++i) {
      const double at_x = pixel.x + 0.5 + dx[i], at_y = pixel.y + 0.5 + dy[i];
      rays[i] = spread() ? camera_.through(at_x, at_y, double(lens_u[i]), double(lens_v[i]),
                                           moves_ ? camera_.time(double(time[i])) : 0.5)
                         : camera_.through(at_x, at_y);
    }
  }
}

}  // namespace penumbra
