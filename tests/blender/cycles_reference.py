# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of both engines for the tests against Cycles, and how they are compared.

Cycles runs with the settings of helpers.use_cycles_as_reference: direct light only, one ray through the pixel's centre.
Its own noise is measured from two seeds in each test, so that a tolerance can be read as so many times the noise.
"""

import numpy as np
from helpers import render_pixels, use_cycles_as_reference

INDEX_PASSES = ("IndexOB", "Object Index")
"""The object index pass up to Blender 4.5 and since."""

NORMAL_TOLERANCE = 5e-5
"""Cycles keeps vertex normals in 16 bits since Blender 5 (seen: 3.1e-5)."""


def render_with_penumbra(scene, light_samples: int = 1024) -> dict[str, np.ndarray]:
    """All passes, with the same number of light points everywhere."""
    scene.penumbra.stop_rule, scene.penumbra.light_samples = "FIXED", light_samples
    return render_pixels(scene, "PENUMBRA")


def render_with_cycles(scene, samples: int, seed: int = 0) -> dict[str, np.ndarray]:
    """All passes; every object gets a `pass_index` of its own, so that object_index() tells them apart (0: nothing)."""
    for index, scene_object in enumerate(scene.objects, start=1):
        scene_object.pass_index = index
    scene.view_layers[0].use_pass_object_index = True
    use_cycles_as_reference(scene, samples)
    scene.cycles.seed = seed
    return render_pixels(scene, "CYCLES")


def converge_cycles(scene, samples: int) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """(passes, noise): Combined is the mean of two seeds, `noise` (height, width, 3) half of their difference.

    The root mean square of `noise` estimates the standard error of Combined; the mean of `noise` that of its mean.
    """
    first, second = (render_with_cycles(scene, samples, seed) for seed in (0, 1))
    noise = (first["Combined"][..., :3].astype(float) - second["Combined"][..., :3]) / 2
    return first | {"Combined": (first["Combined"].astype(float) + second["Combined"]) / 2}, noise


def object_index(passes) -> np.ndarray:
    """(height, width) of Cycles' object index pass."""
    (name,) = (name for name in INDEX_PASSES if name in passes)
    return passes[name][..., 0]


def away_from_edges(passes, margin: int = 0, crease_cosine: float = -1.0) -> np.ndarray:
    """(height, width) bool: pixels of Cycles' picture that show an object and have no edge nearby.

    An edge lies between two neighbours that show different objects or whose normals' cosine is below `crease_cosine`
    (-1: creases do not count). Pixels on either side of an edge, and `margin` more in all directions, are left out.
    """
    index, normal = object_index(passes), passes["Normal"]
    edge = np.zeros(index.shape, dtype=bool)
    for one, other in (np.s_[1:, :], np.s_[:-1, :]), (np.s_[:, 1:], np.s_[:, :-1]):
        jump = (index[one] != index[other]) | ((normal[one] * normal[other]).sum(-1) < crease_cosine)
        edge[one] |= jump
        edge[other] |= jump
    for _ in range(margin):
        height, width = edge.shape
        grown = np.pad(edge, 1)
        edge = np.any([grown[y : y + height, x : x + width] for y in range(3) for x in range(3)], axis=0)
    return ~edge & (index > 0)


def colour(passes) -> np.ndarray:
    """(height, width, 3) float64: red, green, blue of Combined."""
    return passes["Combined"][..., :3].astype(float)


def relative_rmse(difference, reference, where=np.s_[:]) -> float:
    """sqrt(mean of difference^2) / mean of reference, over red, green, blue of the pixels `where`."""
    return float(np.sqrt(np.mean(difference[where] ** 2)) / np.mean(reference[where]))
