// SPDX-License-Identifier: GPL-3.0-or-later
// Where pictures are taken from, through which lens.
#pragma once

#include <cstdint>

#include "math/transform.h"

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

/// Looks along its local -z. `window` is the full frame in the plane z = -1 (perspective) or in world units.
struct Camera {
  CameraKind kind = CameraKind::kPerspective;
  Affine world_from_camera;
  double left = -1, right = 1, bottom = -1, top = 1;
  double clip_start = 0.1, clip_end = 1000;  // along the view axis
  Aperture aperture = {};
};

}  // namespace penumbra
