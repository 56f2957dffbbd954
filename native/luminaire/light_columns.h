// SPDX-License-Identifier: GPL-3.0-or-later
// The far light of many elements at one surface point, in loops over columns.
#pragma once

#include <vector>

#include "luminaire/light_element.h"
#include "scene/surface_columns.h"

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

/// Surface points as the loops want them.
struct ReceiverColumns {
  explicit ReceiverColumns(const SurfaceColumns& surfaces);

  alignas(64) float x[kBatch], y[kBatch], z[kBatch], normal_x[kBatch], normal_y[kBatch], normal_z[kBatch];
  uint32_t count;
};
/// The same as far_light() for one element and many surface points.
bool far_light_each(const std::vector<std::vector<float>>& columns, uint32_t element, int channel,
                    const ReceiverColumns& receivers, float* out, int* state);

/// Elements [first, first + count): sum of the vectors whose product with a surface's normal is what it gets,
/// wherever all elements are above the horizon. Nearer to `middle` than some radii they are four points each.
Vec3d vector_sum(const std::vector<std::vector<float>>& columns, uint32_t first, uint32_t count, int channel,
                 const Vec3d& point, const Vec3d& middle);
/// Sum of the powers of those flat ones whose plane is within `distance` of a point.
double turning_sum(const std::vector<std::vector<float>>& columns, uint32_t first, uint32_t count,
                   int channel, const Vec3d& point, double distance);
/// Distance from which on an element may be four points.
double formula_from(const LightElement& element);

/// Sum of a chunk, as a fixed tree.
float sum_light(const float* values);

}  // namespace penumbra
