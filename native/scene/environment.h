// SPDX-License-Identifier: GPL-3.0-or-later
// A picture of the whole sky.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "math/transform.h"

namespace penumbra {

struct SkyLight;  // luminaire/sky.cpp

/// Equirectangular: columns go from azimuth pi down to -pi (atan2(y, x)), rows from straight down up. Scenes
/// share it.
class SkyPicture {
 public:
  /// pixels: radiance; row 0 is the lowest. Throws std::invalid_argument where there are none, or not finite
  /// ones.
  SkyPicture(uint32_t width, uint32_t height, std::vector<Vec3f> pixels);

  uint32_t width() const { return width_; }
  uint32_t height() const { return height_; }
  const std::vector<Vec3f>& pixels() const { return pixels_; }
  uint64_t hash() const { return hash_; }
  /// What it gives as a light: made when it is first asked for, and kept.
  const SkyLight& light() const;

 private:
  uint32_t width_, height_;
  std::vector<Vec3f> pixels_;
  uint64_t hash_;
  mutable std::once_flag lit_;
  mutable std::shared_ptr<const SkyLight> light_;
};

struct Environment {
  std::shared_ptr<const SkyPicture> picture;
  Affine local_from_world;  // a rotation
  bool smooth = true;       // interpolated between the centres of pixels

  /// Radiance from a direction in the world, of any length.
  Vec3d radiance(const Vec3d& to_sky) const;
};

}  // namespace penumbra
