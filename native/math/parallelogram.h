// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "math/vector.h"

namespace penumbra {

/// Points corner + s edge_u + t edge_v, s and t in 0 ... 1.
struct Parallelogram {
  Vec3d corner, edge_u, edge_v;
};

}  // namespace penumbra
