// SPDX-License-Identifier: GPL-3.0-or-later
// The far light of many elements at one surface point, in loops over columns.
#pragma once

#include <vector>

#include "luminaire/light_element.h"
#include "scene/surface_point.h"

namespace penumbra {

/// Elements handled at a time.
inline constexpr uint32_t kLightChunk = 64;

inline constexpr int kLightColumns = 21;
void add_light_columns(const LightElement& element, const float radiance[4],
                       std::vector<std::vector<float>>& columns);

/// How an element was evaluated: as a point, by four points, or not at all because it is near, or the horizon
/// cuts it.
enum LightState : int { kPointLight, kFourPoints, kNearLight };

/// out[i]: |radiance| x form factor of element first + i, one channel; 0 where state[i] is kNearLight.
/// Returns whether there are such. count: at most kLightChunk.
bool far_light(const std::vector<std::vector<float>>& columns, uint32_t first, uint32_t count, int channel,
               const SurfacePoint& surface, float* out, int* state);

/// What elements send around a point: |radiance| x form factor, one channel, at point + d of a surface with
/// normal n is n . (value + sum of gradient[k] x d[k]) to first order, wherever all of them are above the
/// horizon and face the surface.
struct LightField {
  Vec3d value, gradient[3];
};
/// Adds elements [first, first + count), each as a point.
void add_field(const std::vector<std::vector<float>>& columns, uint32_t first, uint32_t count, int channel,
               const Vec3d& point, LightField& field);

/// Sum of a chunk, as a fixed tree.
float sum_light(const float* values);

}  // namespace penumbra
