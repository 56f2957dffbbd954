// SPDX-License-Identifier: GPL-3.0-or-later
// Primary rays through points of the image plane and of the lens.
#pragma once

#include "scene/normalization.h"
#include "scene/scene.h"
#include "visibility/geometry.h"

namespace penumbra {

/// A ray's t is the distance along the view axis in world units, the same for both kinds of camera: what the
/// Depth pass shows, and what the clip range is about.
class CameraRays {
 public:
  CameraRays(const Camera& camera, const Normalization& normalization, uint32_t width, uint32_t height);

  /// The lens has an opening.
  bool has_lens() const { return camera_.aperture.radius > 0; }
  /// The camera is elsewhere at another time.
  bool moves() const { return !render_from_camera_motion_.empty(); }

  bool is_perspective() const { return camera_.kind == CameraKind::kPerspective; }
  /// Where all of a pinhole's rays come from, or, of parallel ones, the way back along them.
  Vec3d eye() const {
    return is_perspective() ? render_from_camera_.origin : render_from_camera_.vector({0, 0, 1});
  }
  /// From render space to the camera's, in which it looks along -z, in world units.
  Vec3d in_camera(const Vec3d& p) const { return render_from_camera_.inverse_point(p); }
  /// Along the view axis; what is nearer is not seen.
  double clip_start() const { return camera_.clip_start; }
  /// What lies there in the frame: x and y in pixels. p: in the camera's space, before a pinhole.
  Vec3d frame_place(const Vec3d& p) const {
    const double depth = is_perspective() ? -p.z : 1;
    return {(p.x / depth - camera_.window.left) / step_x_, (p.y / depth - camera_.window.bottom) / step_y_,
            0};
  }

  /// Through the point (x, y) of the full frame, in pixels from its bottom left corner, and the middle of the
  /// lens, at the shutter's centre.
  Ray through(double x, double y) const {
    const double u = camera_.window.left + x * step_x_, v = camera_.window.bottom + y * step_y_;
    const Vec3d origin = is_perspective() ? Vec3d{} : Vec3d{u, v, 0};
    const Vec3d direction = is_perspective() ? Vec3d{u, v, -1} : Vec3d{0, 0, -1};
    return {render_from_camera_.point(origin), render_from_camera_.vector(direction), camera_.clip_start,
            camera_.clip_end};
  }

  /// The same, through the place on the lens that a point of the unit square stands for, at a time.
  Ray through(double x, double y, double lens_u, double lens_v, double time) const;

  /// The time of the shutter, distributed as it is open, that a variate in [0, 1) stands for.
  double time(double variate) const;

 private:
  Camera camera_;
  Affine render_from_camera_;
  std::vector<Affine> render_from_camera_motion_;  // none where it stands still
  uint32_t width_, height_;
  double step_x_, step_y_;        // of a pixel, in the window's units
  std::vector<double> exposure_;  // share of the light that came up to each of the shutter's times
};

/// A place of the opening in world units, uniform over its area where (u, v) is over the unit square: the
/// square's rings become the disk's (Shirley and Chiu 1997), or a polygon's.
Vec3d place_on_lens(const Aperture& aperture, double u, double v);

}  // namespace penumbra
