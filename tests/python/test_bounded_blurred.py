# SPDX-License-Identifier: GPL-3.0-or-later
"""The promise of BOUNDED with a lens, with motion and on hair: at least 99 % of the pixels, filter, lens and shutter
included, are within the tolerance.

Oracle: fixed primary rays of another seed with 16 points on each luminaire, on parts of the frame: 16384 rays whose own
standard error is about 0.5 x 16384^-7/12 = 1.7e-3 at the worst full-contrast blur, and a third of that at most pixels.
"""

import functools

import numpy as np
import pytest
from promise_scenes import Stage, leaves, solid_shapes
from scenes import box, render, rotation, sphere, translation
from test_bounded import most_misses

WIDTH, HEIGHT = 96, 72
PARTS = [(x, y, 8, 8) for x in (8, 32, 56, 80) for y in (8, 24, 40)]


def lens(focus, radius=0.15, blades=0):
    """A stage whose camera has an aperture."""
    stage = Stage()
    window = (-0.5, 0.5, -0.375, 0.375)
    stage.scene.set_camera("PERSPECTIVE", stage.camera, window, (0.01, 1000.0), (radius, focus, blades, 0.2, 1.0))
    return stage


def before_the_focus():
    """Everything but the foreground is out of focus; wires before the camera are far out of it."""
    stage = lens(focus=7.0)
    solid_shapes(stage)
    for i in range(3):
        at = translation(3.0 - 0.3 * i, -5.5, 4.2 + 0.5 * i) @ rotation([0, 1, 1], 30 * i)
        stage.add(box([-2, -0.01, -0.01], [2, 0.01, 0.01]), at)
    stage.light(2.0, -2.0, 5, (1.5, 1.5))
    return stage.scene


def leaves_in_focus():
    stage = lens(focus=11.5, radius=0.3, blades=6)
    solid_shapes(stage)
    stage.add(leaves(300, 0.2, seed=81))
    stage.light(2.0, -1.0, 5, (1.0, 1.0))
    stage.bulb(-3.0, 1.0, 4.0, 0.0, 0.4)
    return stage.scene


def on_the_move():
    """A ball and a box cross before a still fence, a ball under a leaf-strewn sky turns; the camera pans a little."""
    stage = Stage()
    solid_shapes(stage)
    scene, grey = stage.scene, stage.scene.add_material("moving", (0.8,) * 3)
    ball = scene.add_mesh("ball", *sphere([0, 0, 0], 0.5, 24))
    way = [translation(-2.5, -2.0, 0.6), translation(-1.0, -2.4, 0.9), translation(0.8, -2.2, 0.6)]
    scene.add_instance("ball", ball, way[1], [grey], motion=way)
    crate = scene.add_mesh("crate", *box([-0.4, -0.1, -0.4], [0.4, 0.1, 0.4]))
    turning = [translation(2.2, 0.5, 1.5) @ rotation([0, 1, 1], angle) for angle in (0, 90)]
    scene.add_instance("crate", crate, turning[0], [grey], motion=turning)
    positions, triangles = leaves(150, 0.2, seed=83)
    number = scene.add_mesh("leaves", positions, triangles, position_motion=[positions, positions + [0.3, 0, 0.1]])
    scene.add_instance("leaves", number, np.eye(4), [grey])
    window = (-0.5, 0.5, -0.375, 0.375)
    poses = [stage.camera, translation(0.1, 0, 0) @ stage.camera]
    scene.set_camera("PERSPECTIVE", stage.camera, window, (0.01, 1000.0), motion=poses, window_motion=[window] * 2)
    stage.light(2.0, -2.0, 5, (1.5, 1.5))
    return scene


def hairy():
    """Strands from far below a pixel to some pixels thick, ribbons and tubes, and some points, over a floor."""
    stage = Stage()
    solid_shapes(stage)
    rng = np.random.default_rng(84)
    fur = stage.scene.add_material("fur", (0.8,) * 3)
    for shape, count, radius in (("RIBBON", 250, 0.01), ("RIBBON", 60, 0.04), ("TUBE", 40, 0.03)):
        root = rng.uniform(-2.5, 2.5, (count, 1, 3)) * [1, 1, 0]
        bend = np.linspace(0, 1, 5)[None, :, None] ** 2 * rng.normal(0, 0.3, (count, 1, 3)) * [1, 1, 0]
        keys = (root + np.linspace(0, 1.0, 5)[None, :, None] * [[0, 0, 1.0]] + bend).astype(np.float32)
        radii = np.tile(np.linspace(radius, radius / 4, 5, dtype=np.float32), count)
        number = stage.scene.add_curves("fur", keys.reshape(-1, 3), radii, np.full(count, 5), shape)
        stage.scene.add_instance("fur", number, np.eye(4), [fur])
    places = rng.uniform([-2.5, -2.5, 0.2], [2.5, 2.5, 1.5], (60, 3)).astype(np.float32)
    number = stage.scene.add_points("dots", places, rng.uniform(0.02, 0.1, 60).astype(np.float32))
    stage.scene.add_instance("dots", number, np.eye(4), [fur])
    stage.light(2.0, -2.0, 5, (1.5, 1.5))
    return stage.scene


SCENES = (before_the_focus, leaves_in_focus, on_the_move, hairy)


def in_parts(scene, **settings):
    """The passes of all parts, one below the other."""
    pictures = [render(scene(), WIDTH, HEIGHT, region=part, **settings).passes for part in PARTS]
    return {name: np.concatenate([passes[name] for passes in pictures]) for name in pictures[0]}


@functools.cache
def reference(scene):
    settings = {"stop_rule": "FIXED", "pixel_samples": 16384, "light_samples": 16, "seed": 4711}
    return in_parts(scene, **settings)["Combined"]


def blurred(scene, **settings):
    return in_parts(scene, **{"stop_rule": "BOUNDED", "pixel_samples": 2, **settings})


@pytest.mark.slow
@pytest.mark.parametrize("tolerance", [0.02, 0.007])
@pytest.mark.parametrize("scene", SCENES)
def test_coverage(scene, tolerance):
    picture, true = blurred(scene, error_tolerance=tolerance), reference(scene)
    error = np.abs(picture["Combined"] - true).max(axis=-1)  # alpha, too
    missed = error > tolerance * np.maximum(1, true.max(axis=-1))
    assert missed.sum() <= most_misses(missed.size), f"{100 * missed.mean():.2f} % of the pixels"


@pytest.mark.parametrize("scene", SCENES)
def test_error_estimate_is_a_bound(scene):
    picture = blurred(scene, error_tolerance=0.02)
    error = np.abs(picture["Combined"] - reference(scene)).max(axis=-1)
    assert (error <= picture["Error Estimate"][..., 0]).mean() >= 0.95
