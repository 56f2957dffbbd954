# SPDX-License-Identifier: GPL-3.0-or-later
"""Point, spot and sun lights from Python: inverse squares, one ray for a point, hard shadows, refusals."""

import numpy as np
import penumbra_native as pn
import pytest
from scenes import add, floor, look_down, parallelogram, render, rotation, translation

RULES = [{"stop_rule": "FIXED", "light_samples": 16}, {"stop_rule": "PAPER"}, {"stop_rule": "BOUNDED"}]


def floor_scene(albedo=0.5):
    scene = pn.Scene()
    add(scene, "floor", floor(), albedo=albedo)
    look_down(scene)
    return scene


@pytest.mark.parametrize("rule", RULES, ids=lambda rule: rule["stop_rule"])
def test_a_point_is_one_exact_ray(rule):
    """E = I cos / r^2, albedo E / pi; single precision of the pass, 1e-6."""
    scene = floor_scene()
    scene.add_point_light("bulb", translation(0.3, 0.1, 1.5), 0.0, (2.0, 1.0, 0.0))
    picture = render(scene, 16, **rule)
    to_light = np.array([0.3, 0.1, 1.5]) - picture.position
    square = (to_light**2).sum(-1)
    np.testing.assert_allclose(picture.red, 0.5 * 2 / np.pi * 1.5 / square**1.5, rtol=2e-6)
    assert (picture.light_samples == 1).all()
    assert picture.statistics["shadow_rays"] == 256
    assert picture.statistics["pixels_at_sample_limit"] == 0
    assert picture.passes["Error Estimate"].max() < 1e-6


@pytest.mark.parametrize("rule", RULES, ids=lambda rule: rule["stop_rule"])
def test_a_point_casts_a_hard_shadow(rule):
    """A square of half side 0.5 at z = 0.75 under a point at 1.5: its shadow has half side 1."""
    scene = floor_scene()
    add(scene, "card", parallelogram([-0.5, -0.5, 0.75], [1, 0, 0], [0, 1, 0]))
    scene.set_camera("ORTHOGRAPHIC", translation(0, 0, 0.5), (-2, 2, -2, 2), (0.1, 10))
    scene.add_point_light("bulb", translation(0, 0, 1.5), 0.0, (1, 1, 1))
    picture = render(scene, 32, **rule)
    hidden = np.abs(picture.position[..., :2]).max(-1) < 1
    assert ((picture.red == 0) == hidden).all() and hidden.sum() == 256


@pytest.mark.parametrize("angle", [0.0, 0.5])
def test_sun_on_a_turned_floor(angle):
    """Irradiance E cos, as long as the whole disk is above the horizon; 4096 points: 1e-5."""
    scene = floor_scene()
    turn = rotation([1, 2, 0], 30)
    scene.add_sun("sun", tuple(turn[:3, 2]), angle, (3.0, 2.0, 1.0))
    picture = render(scene, 8, stop_rule="FIXED", light_samples=4096)
    np.testing.assert_allclose(picture.red, 0.5 * 3 / np.pi * np.cos(np.radians(30)), rtol=1e-5)
    if angle == 0:
        assert (picture.light_samples == 1).all()


def test_a_sphere_that_holds_the_scene_is_a_furnace():
    """Radiance I / (pi r^2) from everywhere: albedo x that."""
    scene = floor_scene()
    scene.add_point_light("sky", translation(0, 0, 1), 20.0, (np.pi * 400,) * 3)
    for rule in RULES:
        np.testing.assert_allclose(render(scene, 8, **rule).red, 0.5, rtol=1e-5)


def test_shadows_can_be_off():
    scene = floor_scene()
    add(scene, "card", floor(half=8.0, z=0.75))
    scene.set_camera("ORTHOGRAPHIC", translation(0, 0, 0.5), (-2, 2, -2, 2), (0.1, 10))
    scene.add_point_light("bulb", translation(0, 0, 1.5), 0.0, (1, 1, 1), False)
    scene.add_sun("sun", (0, 0, 1), 0.0, (1, 1, 1), False)
    picture = render(scene, 8)
    assert (picture.red > 0.1).all() and picture.statistics["shadow_rays"] == 0


@pytest.mark.parametrize(
    "arguments, message",
    [
        ({"radius": -1.0}, "bulb: the radius must be finite and not negative"),
        ({"radius": np.nan}, "bulb: the radius"),
        ({"intensity": (np.inf, 0, 0)}, "bulb: the intensity is not finite"),
        ({"shape": "CUBE"}, "bulb: shape is 'CUBE', expected SPHERE or FACING_DISK"),
        ({"spot": (4.0, 0.5)}, "bulb: the spot's angle must lie in"),
        ({"spot": (1.0, 2.0)}, "bulb: the spot's angle must lie in"),
        ({"spot": (1.0, 0.5), "world_from_light": np.diag([1.0, 1, 0, 1])}, "bulb: a spot's transform"),
    ],
)
def test_refused_point_lights(arguments, message):
    given = {"world_from_light": np.eye(4), "radius": 0.1, "intensity": (1, 1, 1)} | arguments
    with pytest.raises(ValueError, match=message):
        pn.Scene().add_point_light("bulb", **given)


@pytest.mark.parametrize(
    "arguments, message",
    [
        ({"to_sun": (0, 0, 0)}, "sun: the direction"),
        ({"angle": -0.1}, "sun: half the angle must lie in"),
        ({"angle": 3.3}, "sun: half the angle must lie in"),
        ({"irradiance": (np.nan, 0, 0)}, "sun: the irradiance is not finite"),
    ],
)
def test_refused_suns(arguments, message):
    given = {"to_sun": (0, 0, 1), "angle": 0.1, "irradiance": (1, 1, 1)} | arguments
    with pytest.raises(ValueError, match=message):
        pn.Scene().add_sun("sun", **given)
