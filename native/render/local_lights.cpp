// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/local_lights.h"

#include <algorithm>
#include <cmath>

#include "lighting/light_cut.h"

namespace penumbra {
namespace {

/// Pixels from one probe to the next.
constexpr uint32_t kStep = kTile;

std::vector<LitPoint> probe(const RenderContext& c, const Rectangle& block) {
  const uint32_t side = kLocalSide, left = block.x / side * side, bottom = block.y / side * side;
  const uint32_t right = std::min(left + side, c.settings.width),
                 top = std::min(bottom + side, c.settings.height);
  std::vector<Ray> rays;
  for (uint32_t y = bottom + kStep / 2; y < top + kStep / 2; y += kStep)
    for (uint32_t x = left + kStep / 2; x < right + kStep / 2; x += kStep)
      rays.push_back(c.camera.through(std::min(x, right - 1) + 0.5, std::min(y, top - 1) + 0.5));
  std::vector<LitPoint> points;
  uint64_t mirror_rays = 0;
  for (size_t first = 0; first < rays.size(); first += kPacket) {
    HitColumns found;
    PathEnd end;
    const uint32_t count = uint32_t(std::min<size_t>(kPacket, rays.size() - first));
    c.geometry.find_surfaces(&rays[first], count, found);
    for (uint32_t i = 0; i < count; ++i) c.paths.follow(found, i, 0, 0, points, mirror_rays, end);
  }
  return points;
}

RenderContext with_luminaires(RenderContext context, std::span<const Luminaire> luminaires) {
  context.luminaires = luminaires;
  return context;
}

}  // namespace

LocalLights::LocalLights(const RenderContext& context, const LightTree& tree, const Rectangle& block)
    : luminaires_(cut_luminaires(tree, probe(context, block), context.settings.error_tolerance,
                                 std::exp2(context.settings.exposure))),
      context_(with_luminaires(context, luminaires_)) {}

}  // namespace penumbra
