# SPDX-License-Identifier: GPL-3.0-or-later
"""From 10,000 triangles on shadow rays from one point are traced by Embree's coherent traversal, unless it could meet
transparent surfaces twice: the light is the same.

The oracles are the same scene with fewer triangles in a mesh that lies below the floor, where no ray meets it, and
brute force in double precision.
"""

import numpy as np
import penumbra_native as pn
import pytest
from oracles import occluded, triangles_of
from promise_scenes import Stage, leaves
from scenes import add, floor, look_down, parallelogram, render, translation
from test_tinted_shadows import AMBER, glass

FEWER, MORE = 60, 80
"""Columns and rows of the mesh below: 7,200 triangles and 12,800, and none of the scenes adds more than 2,000."""


def below(scene, columns):
    add(scene, "below", parallelogram([-20, -20, -1], [40, 0, 0], [0, 40, 0], columns, columns))


def foliage(stage):
    stage.add(leaves(800, 0.2, seed=11))


def glass_leaves(stage):
    scene = stage.scene
    mesh = scene.add_mesh("glass leaves", *leaves(800, 0.3, seed=12))
    scene.add_instance("glass leaves", mesh, np.eye(4), [glass(scene, AMBER)])


def hair(stage):
    scene, rng = stage.scene, np.random.default_rng(13)
    roots = rng.uniform([-2, -2, 0], [2, 2, 0], (400, 1, 3))
    keys = roots + np.linspace(0, 1, 4)[:, None] * rng.normal([0, 0, 1], [0.5, 0.5, 0.1], (400, 1, 3))
    number = scene.add_curves("hair", keys.reshape(-1, 3).astype(np.float32), np.full(1600, 0.02, np.float32),
                              np.full(400, 4, np.int32), "TUBE")  # fmt: skip
    scene.add_instance("hair", number, np.eye(4), [scene.add_material("hair", (0.5,) * 3)])


def scene_of(fill, columns):
    stage = Stage()
    fill(stage)
    below(stage.scene, columns)
    stage.light(0.5, 0.5, 5, (2, 2))
    stage.bulb(-2.0, 1.0, 4.0, 0.3)
    return stage.scene


@pytest.mark.parametrize("fill", [foliage, glass_leaves, hair], ids=lambda f: f.__name__)
@pytest.mark.parametrize("rule", [
    {"stop_rule": "FIXED", "light_samples": 64},
    {"stop_rule": "BOUNDED", "error_tolerance": 0.004},
    {"stop_rule": "BOUNDED", "error_tolerance": 0.02, "pixel_samples": 16},
], ids=["fixed", "bounded", "antialiased"])  # fmt: skip
def test_what_nobody_sees_changes_nothing(fill, rule):
    """A ray through an edge may count as either side's, as the BVH is another one: in a thousandth of the pixels."""
    size = (32, 24) if "pixel_samples" in rule else (96, 72)
    one, other = (render(scene_of(fill, columns), *size, **{"pixel_samples": 1, **rule}) for columns in (FEWER, MORE))
    assert one.statistics["triangles"] < 10_000 <= other.statistics["triangles"]
    assert one.statistics["shadow_rays"] == pytest.approx(other.statistics["shadow_rays"], rel=0.001)
    difference = np.abs(one.red - other.red)
    assert (difference > 0).mean() <= 0.001
    assert difference.max() <= rule.get("error_tolerance", 2 / 64)


def test_against_brute_force():
    """One point a pixel: light or none. 400 leaves and their shadows on a floor, seen from above."""
    scene = pn.Scene()
    add(scene, "floor", floor())
    positions, triangles = leaves(400, 0.2, seed=14)
    mesh = scene.add_mesh("leaves", positions, triangles)
    material = scene.add_material("leaf", (0.5,) * 3)
    # The camera sees through them.
    scene.add_instance("leaves", mesh, np.eye(4), [material], rays=pn.SHADOW_RAY)
    below(scene, MORE)
    place = translation(0.3, -0.2, 4.0)
    scene.add_point_light("bulb", place, 0.0, (50.0,) * 3, True)
    look_down(scene)
    picture = render(scene, 64, stop_rule="FIXED", light_samples=1, pixel_samples=1)
    assert picture.statistics["triangles"] >= 10_000
    seen = picture.position.reshape(-1, 3)
    hidden = occluded(seen, np.broadcast_to(place[:3, 3], seen.shape), triangles_of(positions, triangles))
    assert 0.1 < hidden.mean() < 0.9
    np.testing.assert_array_equal(picture.red.ravel() == 0, hidden)
