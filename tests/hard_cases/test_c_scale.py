# SPDX-License-Identifier: GPL-3.0-or-later
"""Rows 31 to 35 as whole pictures: the same scene from a micrometre to ten kilometres, at offsets to 1e7 metres.

More of rows 31 and 34, acne and leaks: test_b_acne_and_leaks.py; of 35: test_a_shapes.py.
"""

import numpy as np
import penumbra_native as pn
import pytest
from methods import ANTIALIASED, BOUNDED, FIXED, red
from scenes import add, floor, light_above, lit_floor, look_down, parallelogram, render, scaling, translation

RULES = {"bounded": BOUNDED, "fixed": FIXED, "antialiased": {**ANTIALIASED, "error_tolerance": 0.02}}


def picture(scale=1.0, offset=(0.0, 0.0, 0.0), baked=False, n=24, **settings):
    """A floor, a plate that hangs 1e-5 of the floor's width above it, one higher, and a luminaire."""
    matrix = translation(*offset) @ scaling(scale, scale, scale)
    scene = pn.Scene()
    pieces = {
        "floor": floor(2.0),
        "near plate": parallelogram([-1, -1, 4e-5], [0.8, 0, 0], [0, 0.8, 0]),
        "high plate": parallelogram([0.2, 0.1, 1], [0.7, 0, 0], [0, 0.9, 0.1]),
    }
    for name, (positions, triangles) in pieces.items():
        placed = positions @ matrix[:3, :3].T + matrix[:3, 3] if baked else positions
        add(scene, name, (placed, triangles), np.eye(4) if baked else matrix)
    scene.add_area_light("key", "RECTANGLE", matrix @ light_above(2), (1, 1), (5, 5, 5))
    # Below the floor, looking up, would show it from behind; so from between floor and near plate: a side view.
    camera = translation(*offset)
    camera[2, 3] += 2e-5 * scale
    scene.set_camera("ORTHOGRAPHIC", camera, np.array([-1.6, 1.6, -1.6, 1.6]) * scale, (0, scale))
    return red(scene, n, **settings)


@pytest.mark.parametrize("baked", [False, True])
@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize(
    ("scale", "offset"),
    [(1e-6, 0), (1e-6, 1e-3), (1e4, 0), (1, 1e3), (1, 1e6), (1, 1e7), (1e4, 1e7), (2.0**-20, 2.0**-6)],
)
def test_c31_c32_c33_the_same_picture(scale, offset, rule, baked):
    """Within 1e-3 of the largest value, but for one pixel in a hundred, where the rounding of a vertex moves an edge
    across one of its points; black below the plate that floats at 1e-5 of the floor's width."""
    settings = RULES[rule]
    plain, other = picture(**settings), picture(scale, (offset, -offset, 0.5 * offset), baked, **settings)
    assert (np.abs(other - plain) > 1e-3 * plain.max()).mean() <= 0.01
    c = ((np.arange(24) + 0.5) / 24 * 2 - 1) * 1.6
    below = (c > -0.75) & (c < -0.45)  # further than the filter reaches from its edges
    assert (other[np.ix_(below, below)] == 0).all() and plain.max() > 0.1


@pytest.mark.parametrize("rule", ["FIXED", "PAPER", "VARIANCE", "BOUNDED"])
@pytest.mark.parametrize("radiance", [1e-30, 1e30])
def test_c35_extreme_radiance_with_the_tolerance_scaled(radiance, rule):
    """The exposure moves with the radiance: the same decisions, and the same picture times the power of two. The
    exposure's own limit is 100 stops, 1e30."""
    power = np.round(np.log2(radiance))
    plain = render(lit_floor((1,) * 3), 8, stop_rule=rule)
    other = render(lit_floor((2.0**power,) * 3), 8, stop_rule=rule, exposure=-power)
    np.testing.assert_allclose(other.red, plain.red * 2.0**power, rtol=1e-6)
    assert (other.light_samples == plain.light_samples).all()
    np.testing.assert_allclose(other.passes["Error Estimate"], plain.passes["Error Estimate"], rtol=1e-5)


def test_c35_no_denormal_stall():
    """Radiance so small that every pixel is a float32 denormal: finite, and as many points as ever."""
    picture_of = {r: render(lit_floor((r,) * 3), 16, stop_rule="FIXED", light_samples=256) for r in (1.0, 1e-40)}
    assert np.isfinite(picture_of[1e-40].red).all() and picture_of[1e-40].red.max() < 1e-38
    assert (picture_of[1e-40].light_samples == picture_of[1.0].light_samples).all()


def test_c34_tiny_plate_in_the_middle_of_ten_kilometres():
    """1e-4 m against the same without its surroundings. (Off the centre its vertices are rounded to 1e-7 of the scene's
    extent: the README's limits.)"""

    def plate(surroundings):
        scene = pn.Scene()
        add(scene, "plate", floor(5e-5))
        if surroundings:
            for z in (-5e3, 5e3):
                add(scene, "far", floor(5e3, z))
        scene.add_area_light("key", "RECTANGLE", translation(0, 0, 2e-4), (1e-4, 1e-4), (1, 1, 1))
        look_down(scene, 4e-5, 1e-4)
        return red(scene, 16, **BOUNDED)

    alone = plate(False)
    np.testing.assert_allclose(plate(True), alone, rtol=1e-3)
    assert alone.min() > 0
