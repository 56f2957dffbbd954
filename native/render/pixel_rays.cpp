// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/pixel_rays.h"

#include "sampling/sampler.h"

namespace penumbra {

void PixelRays::make(uint64_t key, uint32_t x, uint32_t y, uint32_t first, uint32_t count, Ray* rays,
                     double* dx, double* dy) const {
  alignas(64) float u[kPacket], v[kPacket], lens_u[kPacket] = {}, lens_v[kPacket] = {}, time[kPacket] = {};
  sampler_.pixel(key, first, count, u, v);
  if (camera_.has_lens()) sampler_.lens(key, first, count, lens_u, lens_v);
  if (moves_) sampler_.time(key, first, count, time);
  for (uint32_t i = 0; i < count; ++i) {
    dx[i] = filter_.offset(double(u[i])), dy[i] = filter_.offset(double(v[i]));
    const double at_x = x + 0.5 + dx[i], at_y = y + 0.5 + dy[i];
    rays[i] = spread() ? camera_.through(at_x, at_y, double(lens_u[i]), double(lens_v[i]),
                                         moves_ ? camera_.time(double(time[i])) : 0.5)
                       : camera_.through(at_x, at_y);
  }
}

}  // namespace penumbra
