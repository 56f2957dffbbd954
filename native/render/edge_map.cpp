// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/edge_map.h"

#include <algorithm>
#include <cmath>

#include "visibility/outlines.h"

namespace penumbra {
namespace {

/// A surface that fills less of a pixel's filter than this share of the tolerance may be left out: what is
/// twice as bright as white is still right to a fifth of it.
constexpr double kUnseenShare = 0.1;

/// A triangle costs about half of what a pixel that needs no camera rays saves, and memory.
constexpr uint64_t kPixelsPerTriangle = 2, kMostTriangles = 1 << 18;

/// Of rounding, pixels.
constexpr double kMargin = 0.01;

/// Of `count` rows or columns, the first and the last whose centres lie between two places; none: first >
/// last.
struct Pixels {
  double first, last;

  Pixels(double low, double high, uint32_t count)
      : first(std::max(std::ceil(low - 0.5), 0.0)),
        last(std::min(std::floor(high - 0.5), double(count) - 1)) {}
};

}  // namespace

EdgeMap::EdgeMap(const Geometry& geometry, const CameraRays& camera, const std::vector<Luminaire>& luminaires,
                 const PixelFilter& filter, const RenderSettings& settings)
    : camera_(camera),
      width_(settings.width),
      height_(settings.height),
      marked_(size_t(settings.width) * settings.height, 0) {
  const double share = std::min(kUnseenShare * settings.error_tolerance, 0.5);
  for (const OutlinePiece& piece : find_outlines(geometry, {camera.eye(), !camera.is_perspective()}))
    mark_line(piece.from, piece.to, filter.reach_of(share) + kMargin);
  for (const Luminaire& luminaire : luminaires) {
    if (!luminaire.role().to_camera) continue;
    for (const LightElement& element : luminaire.elements()) {
      const Vec3d radius{element.radius, element.radius, element.radius};
      Box box;
      box.include(element.centre - radius);
      box.include(element.centre + radius);
      mark_box(box, filter.support() / 2 + kMargin);
    }
  }
}

/// Pixels of a row whose centres lie between two columns' places.
void EdgeMap::mark(uint32_t row, double left, double right) {
  const Pixels columns(left, right, width_);
  if (columns.first <= columns.last)
    std::fill_n(marked_.begin() + ptrdiff_t(size_t(row) * width_ + size_t(columns.first)),
                size_t(columns.last - columns.first) + 1, uint8_t(1));
}

/// Calls function with the ends, in the frame, of what is before the camera of a line in its space.
template <typename Function>
void EdgeMap::for_seen_part(const Vec3d& from, const Vec3d& to, Function function) const {
  const double before = -from.z - camera_.clip_start(), behind = -to.z - camera_.clip_start();
  if (!(before >= 0 || behind >= 0)) return;
  const auto cut = [&] { return from + (to - from) * (before / (before - behind)); };
  function(camera_.frame_place(before >= 0 ? from : cut()), camera_.frame_place(behind >= 0 ? to : cut()));
}

/// Pixels whose centres are less than `reach` from a line along both axes, and some beside its ends.
void EdgeMap::mark_line(const Vec3d& from, const Vec3d& to, double reach) {
  for_seen_part(camera_.in_camera(from), camera_.in_camera(to), [&](Vec3d a, Vec3d b) {
    if (a.y > b.y) std::swap(a, b);
    const Pixels rows(a.y - reach, b.y + reach, height_);
    const double slope = b.y > a.y ? (b.x - a.x) / (b.y - a.y) : 0;
    for (double row = rows.first; row <= rows.last; ++row) {
      // Where the line enters and leaves what is so near to the row.
      const double low = std::max(row + 0.5 - reach, a.y), high = std::min(row + 0.5 + reach, b.y);
      const double in = slope == 0 ? a.x : a.x + (low - a.y) * slope,
                   out = slope == 0 ? b.x : a.x + (high - a.y) * slope;
      mark(uint32_t(row), std::min(in, out) - reach, std::max(in, out) + reach);
    }
  });
}

/// The rectangle of all that a box may cover.
void EdgeMap::mark_box(const Box& box, double reach) {
  Box seen;
  const std::array<Vec3d, 8> corners = box.corners();
  for (uint32_t i = 0; i < 8; ++i)
    for (uint32_t bit = 1; bit < 8; bit <<= 1)
      if (!(i & bit))
        for_seen_part(camera_.in_camera(corners[i]), camera_.in_camera(corners[i | bit]),
                      [&seen](const Vec3d& a, const Vec3d& b) { seen.include(a), seen.include(b); });
  if (seen.empty()) return;
  const Pixels rows(seen.low.y - reach, seen.high.y + reach, height_);
  for (double row = rows.first; row <= rows.last; ++row)
    mark(uint32_t(row), seen.low.x - reach, seen.high.x + reach);
}

std::unique_ptr<const EdgeMap> make_edge_map(const Geometry& geometry, const CameraRays& camera,
                                             const std::vector<Luminaire>& luminaires,
                                             const PixelFilter& filter, const RenderSettings& settings) {
  const uint64_t pixels = uint64_t(settings.width) * settings.height;
  const bool touches_eye = camera.is_perspective() && camera.clip_start() <= 0;
  if (!settings.filtered() || touches_eye || camera.has_lens() || camera.moves() || geometry.moves() ||
      geometry.has_strands() || geometry.triangles() > std::min(pixels / kPixelsPerTriangle, kMostTriangles))
    return nullptr;
  const bool endless = std::ranges::any_of(luminaires, [](const Luminaire& luminaire) {
    return luminaire.role().to_camera && luminaire.elements().empty();
  });
  if (endless) return nullptr;
  return std::make_unique<const EdgeMap>(geometry, camera, luminaires, filter, settings);
}

}  // namespace penumbra
