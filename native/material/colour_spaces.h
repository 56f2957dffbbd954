// SPDX-License-Identifier: GPL-3.0-or-later
// Colours as hue, saturation and value or lightness, each 0 ... 1, and sRGB's transfer curve.
#pragma once

#include "math/vector.h"

namespace penumbra {

Vec3f hsv_from_rgb(const Vec3f& rgb);
Vec3f rgb_from_hsv(const Vec3f& hsv);
Vec3f hsl_from_rgb(const Vec3f& rgb);
Vec3f rgb_from_hsl(const Vec3f& hsl);

/// Linear light of an sRGB value; below 0 it is 0.
float linear_from_srgb(float value);

/// Luminance of linear Rec.709, Blender's default scene-linear space.
inline float luminance(const Vec3f& rgb) {
  return 0.2126729f * rgb.x + 0.7151522f * rgb.y + 0.0721750f * rgb.z;
}

}  // namespace penumbra
