// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/environment.h"

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "sampling/hash.h"

namespace penumbra {

SkyPicture::SkyPicture(uint32_t width, uint32_t height, std::vector<Vec3f> pixels)
    : width_(width), height_(height), pixels_(std::move(pixels)) {
  if (pixels_.empty() || pixels_.size() != size_t(width) * height)
    throw std::invalid_argument("background: the picture has no pixels");
  for (const Vec3f& pixel : pixels_)
    if (!is_finite(pixel))
      throw std::invalid_argument("background: the picture has pixels that are not finite");
  hash_ = hash_array(hash_of(width_, height_), pixels_);
}

Vec3d Environment::radiance(const Vec3d& to_sky) const {
  const Vec3d d = normalize(local_from_world.vector(to_sky));
  const double u = 0.5 - std::atan2(d.y, d.x) / (2 * std::numbers::pi);
  const double v = 1 - std::acos(std::clamp(d.z, -1.0, 1.0)) / std::numbers::pi;
  const uint32_t width = picture->width(), height = picture->height();
  const auto pixel = [&](int64_t x, int64_t y) {
    x = (x % int64_t(width) + width) % width;  // around
    y = std::clamp<int64_t>(y, 0, int64_t(height) - 1);
    return Vec3d(picture->pixels()[size_t(y) * width + size_t(x)]);
  };
  if (!smooth) return pixel(int64_t(std::floor(u * width)), int64_t(std::floor(v * height)));
  const double x = u * width - 0.5, y = v * height - 0.5, left = std::floor(x), bottom = std::floor(y);
  const auto i = int64_t(left), j = int64_t(bottom);
  const double s = x - left, t = y - bottom;
  return (pixel(i, j) * (1 - s) + pixel(i + 1, j) * s) * (1 - t) +
         (pixel(i, j + 1) * (1 - s) + pixel(i + 1, j + 1) * s) * t;
}

}  // namespace penumbra
