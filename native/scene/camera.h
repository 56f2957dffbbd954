// SPDX-License-Identifier: GPL-3.0-or-later
// Where pictures are taken from, through which lens.
#pragma once

#include <cstdint>
#include <vector>

#include "math/motion.h"

namespace penumbra {

enum class CameraKind { kPerspective, kOrthographic };

/// The opening of a thin lens, which a point beyond or before the plane of focus is blurred by.
struct Aperture {
  double radius = 0;          // world units, at the corners of its blades; 0: a pinhole
  double focus_distance = 1;  // along the view axis, world units
  uint32_t blades = 0;        // below 3: round
  double rotation = 0;        // of the blades, radians
  double ratio = 1;           // height over width
};

/// The full frame in the plane z = -1 (perspective) or in world units.
struct Window {
  double left = -1, right = 1, bottom = -1, top = 1;

  friend Window operator*(const Window& w, double s) {
    return {w.left * s, w.right * s, w.bottom * s, w.top * s};
  }
  friend Window operator+(const Window& a, const Window& b) {
    return {a.left + b.left, a.right + b.right, a.bottom + b.bottom, a.top + b.top};
  }
};

/// Looks along its local -z.
struct Camera {
  CameraKind kind = CameraKind::kPerspective;
  Affine world_from_camera;  // these two at the shutter's centre
  Window window = {};
  double clip_start = 0.1, clip_end = 1000;  // along the view axis
  Aperture aperture = {};
  // At evenly spaced times from the shutter's opening to its closing; empty where it stands still.
  std::vector<Affine> motion = {};
  std::vector<Window> window_motion = {};
  // How far the shutter is open at evenly spaced times, any unit; empty: it opens and closes at once.
  std::vector<double> shutter = {};
};

}  // namespace penumbra
