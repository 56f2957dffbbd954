# SPDX-License-Identifier: GPL-3.0-or-later
"""Where things are: the transforms of all instances at once."""

import numpy as np


def world_matrices(instances) -> np.ndarray:
    """(N, 4, 4) float64, world from object, of depsgraph.object_instances in their order."""
    columns = np.empty((len(instances), 4, 4), dtype=np.float32)  # Blender keeps matrices column by column
    instances.foreach_get("matrix_world", columns.ravel())
    return columns.transpose(0, 2, 1).astype(np.float64)
