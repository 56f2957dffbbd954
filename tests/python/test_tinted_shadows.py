# SPDX-License-Identifier: GPL-3.0-or-later
"""Shadows of coloured transparent surfaces: closed forms behind whole panes, the promise behind patterns of glass."""

import numpy as np
import penumbra_native as pn
import pytest
from promise_scenes import Stage, leaves, solid_shapes
from scenes import add, floor, light_above, look_down, parallelogram, render, translation
from test_bounded import most_misses

RULES = {
    "fixed": {"stop_rule": "FIXED", "light_samples": 64},
    "bounded": {"stop_rule": "BOUNDED", "error_tolerance": 0.004},
    "antialiased": {"stop_rule": "BOUNDED", "error_tolerance": 0.004, "pixel_samples": 16},
}
AMBER, CYAN = (0.9, 0.4, 0.05), (0.1, 0.5, 0.8)


def glass(scene, colour, varies=False, **more):
    """A transparent material; varies: computed at each point, though it comes to the same."""
    registers = np.array([(0, 0, 0), colour, (1, 1, 1), (0, 0, 0), (0, 0, 0), (0, 0, 0), (0, 0, 0)], np.float32)
    steps = [("is_ray.shadow", 3, [], 0, 0), ("vector.MULTIPLY", 5, [1, 3], 0, 0)] if varies else []
    closures = [("transparent", 5 if varies else 1, 0, 0, 0)]
    return scene.add_program(f"glass {colour}", registers, steps, np.zeros(0, np.float32), closures, **more)


def beneath(*panes, radiance=(3.0, 2.0, 1.0), **more):
    """A floor below a lamp, and panes in between that all its light crosses; rays of the camera do not meet them."""
    scene = pn.Scene()
    add(scene, "floor", floor())
    mesh = scene.add_mesh("pane", *floor(half=20.0))
    for i, (colour, varies) in enumerate(panes):
        material = glass(scene, colour, varies, **more)
        scene.add_instance("pane", mesh, translation(0, 0, 0.5 + 0.5 * i), [material], rays=pn.SHADOW_RAY)
    scene.add_area_light("lamp", "RECTANGLE", light_above(2.0), (1.0, 1.0), radiance)
    look_down(scene)
    return scene


@pytest.mark.parametrize("rule", RULES.values(), ids=RULES)
@pytest.mark.parametrize("panes", [[(AMBER, False)], [(AMBER, True)], [(AMBER, False), (CYAN, True)]])
def test_a_pane_over_everything_multiplies(panes, rule):
    """What arrives is what would without panes, times their colours: exactly, but where points or rays are drawn."""
    bare = render(beneath(), **rule).passes["Combined"][..., :3]
    tinted = render(beneath(*panes), **rule).passes["Combined"][..., :3]
    expected = bare * np.prod([colour for colour, _ in panes], axis=0)
    tolerance = {"rtol": 1e-5}
    if "pixel_samples" in rule:
        tolerance = {"atol": 2 * 0.004}
    elif rule["stop_rule"] == "FIXED":
        tolerance = {"rtol": 0.02}  # each channel has points of its own
    np.testing.assert_allclose(tinted, expected, **({"rtol": 0} | tolerance))


def test_grey_glass_is_traced_once():
    """Colour costs a ray for each channel, grey does not: where it is constant, and where a program's is told to be."""
    fixed = {"stop_rule": "FIXED", "light_samples": 64, "pixel_samples": 1}
    rays = [render(beneath((colour, varies), **more), **fixed).statistics["shadow_rays"]
            for colour, varies, more in (((0.5,) * 3, False, {}), ((0.5,) * 3, True, {"grey_transparency": True}),
                                         (AMBER, False, {}), ((0.5,) * 3, True, {}))]  # fmt: skip
    assert rays[1] == rays[0] and rays[2] == rays[3] == 3 * rays[0]


def test_light_of_one_colour_is_traced_once():
    red = beneath((AMBER, False), radiance=(2.0, 0.0, 0.0))
    white = beneath((AMBER, False))
    fixed = {"stop_rule": "FIXED", "light_samples": 64, "pixel_samples": 1}
    assert 3 * render(red, **fixed).statistics["shadow_rays"] == render(white, **fixed).statistics["shadow_rays"]


def stained():
    """Glass leaves of three colours, some solid shapes, a lamp and a bulb."""
    stage = Stage()
    solid_shapes(stage)
    for seed, colour in enumerate((AMBER, CYAN, (0.7, 0.05, 0.3))):
        mesh = stage.scene.add_mesh("leaves", *leaves(60, 0.3, seed=50 + seed))
        stage.scene.add_instance("leaves", mesh, np.eye(4), [glass(stage.scene, colour, varies=seed == 1)])
    mesh = stage.scene.add_mesh("pane", *parallelogram([-3, -3, 2], [3, 0, 0], [0, 4, 0]))
    stage.scene.add_instance("pane", mesh, np.eye(4), [glass(stage.scene, (0.2, 0.9, 0.4))], rays=pn.SHADOW_RAY)
    stage.light(2.0, -2.0, 5, (1.5, 1.5), white=0.7)
    stage.bulb(-3.0, 1.0, 4.0, 0.3, white=0.3)
    return stage.scene


@pytest.fixture(scope="module")
def exact():
    """Oracle: 4096 points on each luminaire and channel, another seed; error below 1e-3 (see test_bounded.py)."""
    return render(stained(), 96, 72, stop_rule="FIXED", light_samples=4096, seed=4711).passes["Combined"][..., :3]


@pytest.mark.slow
@pytest.mark.parametrize("tolerance", [0.02, 0.008])
def test_coverage(exact, tolerance):
    picture = render(stained(), 96, 72, stop_rule="BOUNDED", error_tolerance=tolerance).passes
    error = np.abs(picture["Combined"][..., :3] - exact).max(axis=-1)
    missed = error > tolerance * np.maximum(1, exact.max(axis=-1))
    assert missed.sum() <= most_misses(missed.size), f"{100 * missed.mean():.2f} % of the pixels"
    assert (error <= picture["Error Estimate"][..., 0]).mean() >= 0.95
