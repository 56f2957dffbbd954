# SPDX-License-Identifier: GPL-3.0-or-later
"""Paths that would never end: panes that mirror and let through split each ray in two, again and again."""

import numpy as np
import penumbra_native as pn
import pytest
from methods import ANTIALIASED, BOUNDED, FIXED
from scenes import floor, light_above, look_down, render, translation

GLOWING = [("transparent", 1, 0, 0, 0), ("glossy", 2, 2, 0, 0), ("emission", 3, 0, 0, 0)]


def panes(count, through, mirrored):
    """Parallel panes that glow with radiance 1, seen from above; black beyond."""
    scene = pn.Scene()
    registers = np.repeat(np.array([[0], [through], [mirrored], [1]], np.float32), 3, axis=1)
    glass = scene.add_program("glass", registers, [], np.zeros(0, np.float32), GLOWING)
    mesh = scene.add_mesh("pane", *floor())
    for i in range(count):
        scene.add_instance(f"pane {i}", mesh, translation(0, 0, 0.01 * i), [glass])
    scene.add_area_light("key", "RECTANGLE", light_above(5), (1, 1), (1, 1, 1))
    look_down(scene)
    return scene


def seen(count, through, mirrored):
    """What a ray from above sees: radiance going down and up at each pane, by the system of linear equations."""
    equations = np.eye(2 * count)
    for pane in range(count):
        for up, (onward, back) in enumerate(((pane - 1, pane + 1), (pane + 1, pane - 1))):
            row = pane + up * count
            if 0 <= onward < count:
                equations[row, onward + up * count] -= through
            if 0 <= back < count:
                equations[row, back + (1 - up) * count] -= mirrored
    return np.linalg.solve(equations, np.ones(2 * count))[count - 1]


@pytest.mark.parametrize("rule", [BOUNDED, FIXED, ANTIALIASED])
@pytest.mark.parametrize(
    ("count", "through", "mirrored", "tolerance"),
    [(2, 0.5, 0.5, 1e-4), (4, 0.96, 0.04, 1e-4), (8, 0.96, 0.04, 1e-3), (8, 0.5, 0.04, 1e-3), (3, 0.5, 0.5, 5e-3)],
)
def test_d42_panes_that_mirror_each_other(count, through, mirrored, tolerance, rule):
    """What is left out is dim: shares of less than 1e-5, doubled for every 1024 rays."""
    picture = render(panes(count, through, mirrored), 4, mirror_depth=1024, **rule)
    np.testing.assert_allclose(picture.red, seen(count, through, mirrored), rtol=tolerance)


@pytest.mark.parametrize("rule", [BOUNDED, FIXED, ANTIALIASED])
@pytest.mark.parametrize(("through", "mirrored"), [(0.5, 0.5), (1, 1), (2, 2), (1e20, 1e20)])
def test_d42_panes_without_end(through, mirrored, rule):
    """60 of them that lose nothing, or make light: 2^60 rays a pixel without a limit. The limit counts, and what leaves
    the numbers' range is black and counted."""
    picture = render(panes(60, through, mirrored), 4, mirror_depth=1024, **rule)
    rays = picture.statistics["primary_rays"]
    assert 1000 * 16 < picture.statistics["mirror_rays"] <= (17 * 1024 + 300) * rays
    assert all(np.isfinite(values).all() for values in picture.passes.values())
