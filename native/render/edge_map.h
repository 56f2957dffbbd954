// SPDX-License-Identifier: GPL-3.0-or-later
// Which pixels of a frame may show more than one surface: those whose filter lies over an edge of a triangle
// where surfaces end. In all others one camera ray tells what there is.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "luminaire/luminaire.h"
#include "render/camera_rays.h"
#include "render/pixel_filter.h"
#include "render/settings.h"

namespace penumbra {

/// Surfaces that pass through each other have no edge there: neighbouring pixels tell.
class EdgeMap {
 public:
  /// luminaires: that the camera sees themselves; of finite extent.
  EdgeMap(const Geometry& geometry, const CameraRays& camera, const std::vector<Luminaire>& luminaires,
          const PixelFilter& filter, const RenderSettings& settings);

  /// Pixel of the full frame, column and row from its bottom left.
  bool may_show_edge(uint32_t x, uint32_t y) const { return marked_[size_t(y) * width_ + x]; }

 private:
  void mark(uint32_t row, double left, double right);
  void mark_line(const Vec3d& from, const Vec3d& to, double reach);
  void mark_box(const Box& box, double reach);
  template <typename Function>
  void for_seen_part(const Vec3d& from, const Vec3d& to, Function function) const;

  const CameraRays& camera_;
  uint32_t width_, height_;
  std::vector<uint8_t> marked_;
};

/// None where nothing can be told, or it would take longer than it saves: all pixels may show edges then.
std::unique_ptr<const EdgeMap> make_edge_map(const Geometry& geometry, const CameraRays& camera,
                                             const std::vector<Luminaire>& luminaires,
                                             const PixelFilter& filter, const RenderSettings& settings);

}  // namespace penumbra
