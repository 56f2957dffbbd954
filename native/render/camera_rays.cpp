// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/camera_rays.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace penumbra {

using std::numbers::pi;

Vec3d place_on_lens(const Aperture& aperture, double u, double v) {
  if (aperture.radius == 0) return {};
  const double a = 2 * u - 1, b = 2 * v - 1;
  if (a == 0 && b == 0) return {};
  const bool wide = std::abs(a) > std::abs(b);
  const double ring = wide ? a : b;  // negative on the far side of the middle
  double angle = wide ? pi / 4 * (b / a) : pi / 2 - pi / 4 * (a / b);
  Vec3d place;
  if (aperture.blades < 3) {
    place = {ring * std::cos(angle), ring * std::sin(angle), 0};
  } else {
    // The angle goes round a polygon at even speed instead: each blade gets its share of it.
    if (ring < 0) angle += pi;
    const double blade = 2 * pi / aperture.blades, turns = angle / blade, at = std::floor(turns + 0.5);
    const double share = turns + 0.5 - at, low = aperture.rotation + (at - 0.5) * blade;
    const double x = (1 - share) * std::cos(low) + share * std::cos(low + blade),
                 y = (1 - share) * std::sin(low) + share * std::sin(low + blade);
    place = {std::abs(ring) * x, std::abs(ring) * y, 0};
  }
  place.x /= aperture.ratio;
  return place * aperture.radius;
}

CameraRays::CameraRays(const Camera& camera, const Normalization& normalization, uint32_t width,
                       uint32_t height)
    : camera_(camera),
      render_from_camera_(normalization.transform(camera.world_from_camera)),
      width_(width),
      height_(height),
      step_x_((camera.window.right - camera.window.left) / width),
      step_y_((camera.window.top - camera.window.bottom) / height) {
  for (const Affine& pose : subdivided(camera.motion))
    render_from_camera_motion_.push_back(normalization.transform(pose));
  double sum = 0;
  for (const double open : camera.shutter) exposure_.push_back(sum += open);
  for (double& share : exposure_) share /= sum;
}

double CameraRays::time(double variate) const {
  if (exposure_.empty()) return variate;
  const size_t i =
      size_t(std::upper_bound(exposure_.begin(), exposure_.end() - 1, variate) - exposure_.begin());
  const double low = i ? exposure_[i - 1] : 0, high = exposure_[i];
  return (double(i) + (high > low ? (variate - low) / (high - low) : 0.5)) / double(exposure_.size());
}

Ray CameraRays::through(double x, double y, double lens_u, double lens_v, double time) const {
  const Affine render_from_camera = at_time(render_from_camera_motion_, render_from_camera_, time);
  const Window window = at_time(camera_.window_motion, camera_.window, time);
  const double u = window.left + x * ((window.right - window.left) / width_),
               v = window.bottom + y * ((window.top - window.bottom) / height_);
  const bool perspective = camera_.kind == CameraKind::kPerspective;
  const Vec3d place = place_on_lens(camera_.aperture, lens_u, lens_v);
  // All rays of a point of the frame meet in the plane of focus; t stays the distance along the axis.
  const Vec3d towards = place / -camera_.aperture.focus_distance;
  const Vec3d origin = perspective ? place : Vec3d{u, v, 0} + place;
  const Vec3d direction = (perspective ? Vec3d{u, v, -1} : Vec3d{0, 0, -1}) + towards;
  return {render_from_camera.point(origin),
          render_from_camera.vector(direction),
          camera_.clip_start,
          camera_.clip_end,
          kCameraRay,
          time};
}

}  // namespace penumbra
