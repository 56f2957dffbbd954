// SPDX-License-Identifier: GPL-3.0-or-later
// Where surfaces end, for an eye: what a picture's edges come from, but for surfaces that pass through each
// other.
#pragma once

#include <vector>

#include "visibility/geometry.h"

namespace penumbra {

/// From where a scene is looked at, in render space.
struct Eye {
  Vec3d place;  // or, of parallel rays, towards where they come from
  bool parallel = false;

  Eye seen_from(const Affine& render_from_mesh) const {
    return {parallel ? render_from_mesh.inverse_vector(place) : render_from_mesh.inverse_point(place),
            parallel};
  }
};

/// A straight piece of an outline, render space.
struct OutlinePiece {
  Vec3d from, to;
};

/// Edges of all triangles, in the middle of the shutter's time, that do not lie within a surface that is
/// smooth there: those of a single triangle, or of more than two, between two of which the eye sees the
/// fronts of one and the backs of the other, or that are not same_surface() or shaded as one. Those that
/// something hides included. A piece may come twice.
std::vector<OutlinePiece> find_outlines(const Geometry& geometry, const Eye& eye);

}  // namespace penumbra
