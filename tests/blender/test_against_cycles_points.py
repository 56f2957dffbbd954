# SPDX-License-Identifier: GPL-3.0-or-later
"""Point, spot and sun lights, and soft boxes, against Cycles in the same Blender: power, radius, cone, shadows."""

import math

import numpy as np
import pytest
from cycles_reference import colour, converge_cycles, relative_rmse, render_with_penumbra
from helpers import add_camera, add_cube, add_light, add_plane

TILTED = {"location": (0.8, -0.5, 2.0), "rotation": (0.5, -0.4, 0.3)}
LIGHTS = {
    "point": ("POINT", {"shadow_soft_size": 0.0}, {"location": (0.3, -0.2, 2.0)}),
    "ball": ("POINT", {"shadow_soft_size": 0.3}, {"location": (0.3, -0.2, 1.5)}),
    "ball on the floor": ("POINT", {"shadow_soft_size": 0.8}, {"location": (0.3, -0.2, 0.4)}),
    "scaled ball": ("POINT", {"shadow_soft_size": 0.5}, {"location": (0, 0, 2.0), "scale": (2.0, 0.5, 3.0)}),
    "spot": ("SPOT", {"shadow_soft_size": 0.0, "spot_size": 1.1, "spot_blend": 0.3}, TILTED),
    "hard spot": ("SPOT", {"shadow_soft_size": 0.0, "spot_size": 0.8, "spot_blend": 0.0}, TILTED),
    "soft wide spot": ("SPOT", {"shadow_soft_size": 0.4, "spot_size": 2.4, "spot_blend": 1.0}, TILTED),
    "spot of some radius": ("SPOT", {"shadow_soft_size": 0.3, "spot_size": 1.0, "spot_blend": 0.15}, TILTED),
    "scaled spot": ("SPOT", {"shadow_soft_size": 0.0, "spot_size": 0.9, "spot_blend": 0.4},
                    TILTED | {"scale": (1.5, 0.7, 1.0)}),
    "soft box": ("AREA", {"size": 1.0, "spread": math.radians(60)}, TILTED),
    "narrow soft box": ("AREA", {"size": 1.5, "spread": math.radians(5)}, TILTED),
    "round soft box": ("AREA", {"shape": "ELLIPSE", "size": 1.0, "size_y": 0.6, "spread": math.radians(120)}, TILTED),
    "sun": ("SUN", {"angle": 0.0}, {"rotation": (0.4, 0.3, 0.0)}),
    "real sun": ("SUN", {"angle": math.radians(0.526)}, {"rotation": (1.0, 0.3, 0.0), "scale": (2, 2, 2)}),
    "wide sun": ("SUN", {"angle": math.radians(40)}, {"rotation": (0.6, 0.2, 0.0)}),
    "mirrored sun": ("SUN", {"angle": math.radians(5)}, {"rotation": (0.6, 0.2, 0.0), "scale": (-1, 1, 1)}),
}  # fmt: skip


@pytest.mark.parametrize("light", LIGHTS.values(), ids=LIGHTS)
def test_pictures_are_those_of_cycles(scene, light):
    """A floor without occluders. Tolerance 0.3 % in the mean and 1 % (relative RMSE), Cycles' noise below 0.4 %; a
    spot's hard edge may fall on one side of a pixel's centre or the other."""
    kind, data, transform = light
    add_plane(scene, "Floor", size=10.0)
    add_camera(scene, location=(0, 0, 8), type="ORTHO", ortho_scale=6.0)
    add_light(scene, kind, power=3.0 if kind == "SUN" else 100.0, color=(1.0, 0.5, 0.2), data=data, **transform)
    cycles, noise = converge_cycles(scene, samples=512)
    ours, expected = colour(render_with_penumbra(scene)), colour(cycles)
    assert expected.mean() > 0.01
    assert abs(noise.mean((0, 1)) / expected.mean((0, 1))).max() < 1e-3
    assert relative_rmse(noise, expected) < 4e-3
    np.testing.assert_allclose(ours.mean((0, 1)), expected.mean((0, 1)), rtol=3e-3)
    assert relative_rmse(ours - expected, expected) < 1e-2


SHADOWS = {
    "point": ("POINT", {"shadow_soft_size": 0.0}, {"location": (0.3, -0.2, 3.0)}),
    "ball": ("POINT", {"shadow_soft_size": 0.4}, {"location": (0.3, -0.2, 3.0)}),
    "spot": ("SPOT", {"shadow_soft_size": 0.3, "spot_size": 1.2, "spot_blend": 0.5}, {"location": (0.3, -0.2, 4.0)}),
    "sun": ("SUN", {"angle": 0.0}, {"rotation": (0.6, 0.3, 0.0)}),
    "wide sun": ("SUN", {"angle": math.radians(20)}, {"rotation": (0.6, 0.3, 0.0)}),
}  # fmt: skip


@pytest.mark.parametrize("light", SHADOWS.values(), ids=SHADOWS)
def test_shadows_are_those_of_cycles(scene, light):
    """A cube on a floor, by the fixed rule. Tolerance 1.5 % (relative RMSE), Cycles' noise below half of that."""
    kind, data, transform = light
    add_plane(scene, "Floor", size=10.0)
    add_cube(scene, size=1.0, location=(0, 0, 0.6))
    add_camera(scene, location=(0, 0, 8), type="ORTHO", ortho_scale=6.0)
    add_light(scene, kind, power=3.0 if kind == "SUN" else 200.0, data=data, **transform)
    cycles, noise = converge_cycles(scene, samples=512)
    ours, expected = colour(render_with_penumbra(scene)), colour(cycles)
    assert expected.min() < 0.01 * expected.max()
    assert relative_rmse(noise, expected) < 7e-3
    assert relative_rmse(ours - expected, expected) < 1.5e-2
