# SPDX-License-Identifier: GPL-3.0-or-later
"""Area lights against Cycles in the same Blender: power, shape, place, the side they shine to, shadows, visibility."""

import math

import numpy as np
import pytest
from cycles_reference import colour, converge_cycles, relative_rmse, render_with_cycles, render_with_penumbra
from helpers import add_area_light, add_camera, add_cube, add_plane

LIGHTS = {
    "square": [{"shape": "SQUARE", "size": 1.2}],
    "rectangle": [{"shape": "RECTANGLE", "size": 2.0, "size_y": 0.6}],
    "disk": [{"shape": "DISK", "size": 1.2}],
    "ellipse": [{"shape": "ELLIPSE", "size": 0.7, "size_y": 1.6}],
    "rotated": [{"shape": "SQUARE", "size": 1.2, "rotation": (0.7, -0.5, 0.4)}],
    "rotated ellipse": [{"shape": "ELLIPSE", "size": 1.6, "size_y": 0.8, "rotation": (-0.4, 0.6, 0.9)}],
    "scaled": [{"shape": "SQUARE", "size": 1.2, "scale": (0.5, 2.0, 3.0)}],
    "scaled disk": [{"shape": "DISK", "size": 1.2, "scale": (1.7, 0.6, 0.2)}],
    "mirrored": [{"shape": "RECTANGLE", "size": 1, "size_y": 0.6, "scale": (-1.5, 1, 1), "rotation": (0.3, 0.2, 0.8)}],
    "two colours": [
        {"size": 1.0, "color": (1.0, 0.3, 0.1), "location": (-1.5, 0.3, 2.5), "power": 60.0},
        {"size": 0.8, "color": (0.1, 0.4, 1.0), "location": (1.2, -0.6, 3.0), "rotation": (0.0, 0.5, 0.0)},
    ],
    "negative": [{"size": 1.2, "power": -100.0}],
}  # fmt: skip


def add_floor_seen_from_above(scene) -> None:
    """A 10 m floor of 80 % grey; the picture shows the middle 6 m x 4.5 m of it."""
    add_plane(scene, "Floor", size=10.0)
    add_camera(scene, location=(0, 0, 8), type="ORTHO", ortho_scale=6.0)


@pytest.mark.parametrize("lights", LIGHTS.values(), ids=LIGHTS)
def test_converged_pictures_have_the_same_mean(scene, lights):
    """Tolerance 0.2 % in red, green and blue (seen: 0.002 %); Cycles' noise of the mean below a tenth of that."""
    add_floor_seen_from_above(scene)
    for number, light in enumerate(lights):
        add_area_light(scene, f"Light {number}", **{"location": (0.3, -0.2, 3.0)} | light)
    cycles, noise = converge_cycles(scene, samples=128)
    expected = colour(cycles).mean((0, 1))
    assert abs(expected).min() > 0.01
    assert abs(noise.mean((0, 1)) / expected).max() < 2e-4
    np.testing.assert_allclose(colour(render_with_penumbra(scene)).mean((0, 1)), expected, rtol=2e-3)


@pytest.mark.parametrize("scale", [(1, 1, 1), (-1, 1, 1), (1, 1, -1), (-1, -1, -1)], ids=str)
@pytest.mark.parametrize("shape", ["SQUARE", "DISK"])
def test_light_shines_to_one_side_only(scene, shape, scale):
    """An upright light: the floor before it is lit as in Cycles, the floor behind it black, also with mirrored objects.

    Tolerance 0.2 % (relative RMSE) on the lit side, where Cycles' noise must be below half of that.
    """
    add_floor_seen_from_above(scene)
    add_area_light(scene, shape=shape, location=(0, 0, 1.5), rotation=(0, math.pi / 2, 0), scale=scale)
    left_is_lit = scale[2] > 0  # local -z is the world's -x
    cycles, noise = converge_cycles(scene, samples=256)
    ours, expected = colour(render_with_penumbra(scene)), colour(cycles)
    halves = np.s_[:, :32], np.s_[:, 32:]
    lit, dark = halves if left_is_lit else halves[::-1]
    assert not expected[dark].any() and not ours[dark].any()
    assert expected[lit].min() > 0
    assert relative_rmse(noise, expected, lit) < 1e-3
    assert relative_rmse(ours - expected, expected, lit) < 2e-3


def switch_shadow_off(light) -> None:
    """Up to Blender 4.2 Cycles looks at a switch of its own and ignores `use_shadow`."""
    owner = light.cycles if hasattr(light.cycles, "cast_shadow") else light
    setattr(owner, "cast_shadow" if owner is not light else "use_shadow", False)


@pytest.mark.parametrize("has_shadow", [True, False])
def test_shadow_of_a_light_is_switched_as_in_cycles(scene, has_shadow):
    """A cube hides the light from the middle of the floor; the camera is below the cube.

    Tolerance 0.5 % (relative RMSE); Cycles' noise, nearly all in the penumbra, must be below 0.25 %. Cycles samples the
    light only: with its multiple importance sampling the rays that sample the BSDF are blocked even if the light has no
    shadow, and the floor gets 0.12 % too dark.
    """
    add_plane(scene, "Floor", size=10.0)
    add_cube(scene, size=0.8, location=(0, 0, 1.6))
    light = add_area_light(scene, location=(0, 0, 3)).data
    add_camera(scene, location=(0, 0, 1.0), type="ORTHO", ortho_scale=6.0)
    if not has_shadow:
        switch_shadow_off(light)
    light.cycles.use_multiple_importance_sampling = False
    cycles, noise = converge_cycles(scene, samples=512)
    ours, expected = colour(render_with_penumbra(scene)), colour(cycles)
    middle = np.s_[23:25, 31:33]
    assert expected[middle].any() == ours[middle].any() == (not has_shadow)
    assert relative_rmse(noise, expected) < 2.5e-3
    assert relative_rmse(ours - expected, expected) < 5e-3


@pytest.mark.parametrize("rotation", [(0, 0, 0), (math.pi, 0, 0)], ids=["its back", "its face"])
def test_light_itself_is_not_seen_by_the_camera(scene, rotation):
    """Blender's lights start with their visibility to camera rays switched off."""
    add_area_light(scene, size=2.0, location=(0, 0, 1), rotation=rotation)
    add_camera(scene, location=(0, 0, 5))
    assert not colour(render_with_cycles(scene, samples=16)).any()
    assert not colour(render_with_penumbra(scene)).any()
