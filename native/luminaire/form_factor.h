// SPDX-License-Identifier: GPL-3.0-or-later
// Closed forms: what a point receives from a luminaire that nothing hides.
#pragma once

#include <span>

#include "math/vector.h"
#include "scene/surface_columns.h"

namespace penumbra {

/// Form factor E / (pi L_e) of a plane polygon of constant radiance, from the origin with unit normal n; the
/// part below the horizon does not count. `vertices`: at most kMostVertices of a convex polygon in order,
/// relative to the receiving point; `edges[i]`: from vertex i to the next, given apart because the difference
/// of two far vertices has lost its digits.
/// Lambert's formula (1760) in the form of atan2 of |a x (b - a)| and a . b, which keeps its precision for
/// small and for far luminaires, where the arc cosine of a dot product loses all of it.
double polygon_form_factor(std::span<const Vec3d> vertices, std::span<const Vec3d> edges,
                           const Vec3d& normal);

/// The same for many surface points: the polygon's corner lies at `corner` (render space), its vertices
/// relative to that; `facing` is its normal. out[i] is 0 for points behind the polygon.
void polygon_form_factors(std::span<const Vec3d> vertices, std::span<const Vec3d> edges, const Vec3d& corner,
                          const Vec3d& facing, const SurfaceColumns& points, double* out);

inline constexpr size_t kMostVertices = 64;

}  // namespace penumbra
