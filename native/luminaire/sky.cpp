// SPDX-License-Identifier: GPL-3.0-or-later
#include "luminaire/sky.h"

#include "luminaire/sky_emitter.h"

namespace penumbra {
namespace {

/// Pixels of a picture beyond which it is averaged down before it gives light: 0.18 degrees each.
constexpr uint32_t kWidest = 2048, kHighest = 1024;

/// Averages of whole blocks of pixels.
Environment reduced(const Environment& sky) {
  const uint32_t nx = (sky.width + kWidest - 1) / kWidest, ny = (sky.height + kHighest - 1) / kHighest;
  Environment small{sky.width / nx, sky.height / ny, {}, sky.local_from_world, sky.smooth};
  small.pixels.resize(size_t(small.width) * small.height);
  // Edges of a size that is no multiple go to the nearest block.
  std::vector<uint32_t> counts(small.pixels.size());
  std::vector<Vec3d> sums(small.pixels.size());
  for (uint32_t y = 0; y < sky.height; ++y)
    for (uint32_t x = 0; x < sky.width; ++x) {
      const size_t i = size_t(uint64_t(y) * small.height / sky.height) * small.width +
                       size_t(uint64_t(x) * small.width / sky.width);
      sums[i] += Vec3d(sky.pixels[size_t(y) * sky.width + x]);
      ++counts[i];
    }
  for (size_t i = 0; i < sums.size(); ++i) small.pixels[i] = Vec3f(sums[i] / double(counts[i]));
  return small;
}

std::vector<float> channel(const Environment& sky, int index) {
  std::vector<float> values(sky.pixels.size());
  for (size_t i = 0; i < values.size(); ++i) values[i] = std::max(sky.pixels[i][index], 0.0f);
  return values;
}

/// Do all pixels have the hue of their mean, to single precision's rounding?
bool has_one_hue(const Environment& sky) {
  Vec3d mean;
  for (const Vec3f& p : sky.pixels) mean += Vec3d(p);
  if (max_component(mean) <= 0) return true;
  mean = mean / max_component(mean);
  for (const Vec3f& p : sky.pixels) {
    const Vec3d v(p);
    if (max_abs(v - mean * max_component(v)) > 1e-5 * max_component(v)) return false;
  }
  return true;
}

}  // namespace

std::vector<Luminaire> sky_luminaires(const Background& background) {
  std::vector<Luminaire> result;
  if (!background.lights) return result;
  if (!background.environment) {
    result.emplace_back("world", std::make_shared<ConstantSky>(), background.color, true, LuminaireRole{},
                        background.light_group);
    return result;
  }
  const Environment sky = reduced(*background.environment);
  const Vec3d& c = background.color;
  const auto add = [&](int index, const Vec3d& color) {
    const auto emitter =
        std::make_shared<PictureSky>(channel(sky, index), sky.width, sky.height, sky.local_from_world);
    result.emplace_back("world", emitter, color * emitter->mean(), true, LuminaireRole{},
                        background.light_group);
  };
  if (has_one_hue(sky)) {
    Vec3d hue;
    for (const Vec3f& p : sky.pixels) hue += Vec3d(p);
    const int strongest = hue.x >= hue.y && hue.x >= hue.z ? 0 : hue.y >= hue.z ? 1 : 2;
    if (hue[strongest] > 0) add(strongest, c * (hue / hue[strongest]));
    return result;
  }
  add(0, {c.x, 0, 0});
  add(1, {0, c.y, 0});
  add(2, {0, 0, c.z});
  return result;
}

}  // namespace penumbra
