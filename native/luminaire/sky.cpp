// SPDX-License-Identifier: GPL-3.0-or-later
#include "luminaire/sky.h"

#include "luminaire/sky_emitter.h"

namespace penumbra {
namespace {

/// Pixels of a picture beyond which it is averaged down before it gives light: 0.18 degrees each.
constexpr uint32_t kWidest = 2048, kHighest = 1024;

struct Reduced {
  uint32_t width, height;
  std::vector<Vec3f> pixels;
};

/// Averages of whole blocks of pixels.
Reduced reduced(const SkyPicture& sky) {
  const uint32_t nx = (sky.width() + kWidest - 1) / kWidest, ny = (sky.height() + kHighest - 1) / kHighest;
  if (nx == 1 && ny == 1) return {sky.width(), sky.height(), sky.pixels()};
  Reduced small{sky.width() / nx, sky.height() / ny, {}};
  small.pixels.resize(size_t(small.width) * small.height);
  // Edges of a size that is no multiple go to the nearest block.
  std::vector<uint32_t> counts(small.pixels.size());
  std::vector<Vec3d> sums(small.pixels.size());
  for (uint32_t y = 0; y < sky.height(); ++y)
    for (uint32_t x = 0; x < sky.width(); ++x) {
      const size_t i = size_t(uint64_t(y) * small.height / sky.height()) * small.width +
                       size_t(uint64_t(x) * small.width / sky.width());
      sums[i] += Vec3d(sky.pixels()[size_t(y) * sky.width() + x]);
      ++counts[i];
    }
  for (size_t i = 0; i < sums.size(); ++i) small.pixels[i] = Vec3f(sums[i] / double(counts[i]));
  return small;
}

/// Do all pixels have the hue of their mean, to single precision's rounding?
bool has_one_hue(const std::vector<Vec3f>& pixels) {
  Vec3d mean;
  for (const Vec3f& p : pixels) mean += Vec3d(p);
  if (max_component(mean) <= 0) return true;
  mean = mean / max_component(mean);
  for (const Vec3f& p : pixels) {
    const Vec3d v(p);
    if (max_abs(v - mean * max_component(v)) > 1e-5 * max_component(v)) return false;
  }
  return true;
}

}  // namespace

/// A picture's light: one part for each luminaire that it is.
struct SkyLight {
  struct Part {
    std::shared_ptr<const SkyTable> table;
    Vec3d hue;
  };
  std::vector<Part> parts;

  explicit SkyLight(const SkyPicture& picture) {
    const Reduced sky = reduced(picture);
    const auto add = [&](int channel, const Vec3d& hue) {
      std::vector<float> weights;
      for (const Vec3f& pixel : sky.pixels) weights.push_back(std::max(pixel[channel], 0.0f));
      parts.push_back({std::make_shared<SkyTable>(weights, sky.width, sky.height), hue});
    };
    if (has_one_hue(sky.pixels)) {
      Vec3d hue;
      for (const Vec3f& p : sky.pixels) hue += Vec3d(p);
      const int strongest = hue.x >= hue.y && hue.x >= hue.z ? 0 : hue.y >= hue.z ? 1 : 2;
      if (hue[strongest] > 0) add(strongest, hue / hue[strongest]);
      return;
    }
    add(0, {1, 0, 0});
    add(1, {0, 1, 0});
    add(2, {0, 0, 1});
  }
};

const SkyLight& SkyPicture::light() const {
  std::call_once(lit_, [this] { light_ = std::make_shared<const SkyLight>(*this); });
  return *light_;
}

std::vector<Luminaire> sky_luminaires(const Background& background) {
  std::vector<Luminaire> result;
  if (!background.lights) return result;
  if (!background.environment) {
    result.emplace_back("world", std::make_shared<ConstantSky>(), background.color, true, LuminaireRole{},
                        background.light_group);
    return result;
  }
  const Environment& sky = *background.environment;
  for (const auto& [table, hue] : sky.picture->light().parts)
    result.emplace_back("world", std::make_shared<PictureSky>(table, sky.local_from_world),
                        background.color * hue * table->mean(), true, LuminaireRole{},
                        background.light_group);
  return result;
}

}  // namespace penumbra
