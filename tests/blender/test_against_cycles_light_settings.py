# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of lights and their nodes against Cycles in the same Blender: normalization, exposure, temperature, nodes.

A white floor below a light, looked at from above. Means within 0.3 %, as in the other tests of lights; colours of black
bodies, of which both engines have a fit of their own, within 2 % of the largest component (1200 K, where only the red
end of the spectrum is left: 5 %; 4.2 % measured).
"""

import bpy
import numpy as np
import pytest
from cycles_reference import colour, converge_cycles, render_with_cycles, render_with_penumbra
from helpers import add_camera, add_light, add_plane, diffuse_material
from penumbra import statistics

LIGHTS = {
    "square": ("AREA", {"size": 0.5}),
    "disk": ("AREA", {"size": 2.0, "shape": "DISK"}),
    "ball": ("POINT", {"shadow_soft_size": 0.3}),
    "point": ("POINT", {"shadow_soft_size": 0.0}),
    "spot": ("SPOT", {"shadow_soft_size": 0.3, "spot_blend": 0.5, "spot_size": 1.5}),
    "sun": ("SUN", {"angle": 0.4}),
    "sharp sun": ("SUN", {"angle": 0.0}),
}


def floor_below(scene, name, **settings):
    kind, data = LIGHTS[name]
    add_plane(scene, size=4).data.materials.append(diffuse_material("White", (1, 1, 1)))
    add_camera(scene, location=(0, 0, 5))
    return add_light(scene, kind, data={**data, **settings}, power=10.0, location=(0.2, 0.1, 2)).data


def assert_alike(scene) -> None:
    ours = colour(render_with_penumbra(scene, 256))
    assert statistics.last_render["warnings"] == []
    cycles, _ = converge_cycles(scene, 64)
    np.testing.assert_allclose(ours.mean((0, 1)), colour(cycles).mean((0, 1)), rtol=3e-3)


@pytest.mark.skipif("normalize" not in bpy.types.Light.bl_rna.properties, reason="Blender 4.5 and later have it")
@pytest.mark.parametrize("name", LIGHTS)
def test_normalize_off(scene, name):
    floor_below(scene, name, normalize=False)
    assert_alike(scene)


@pytest.mark.skipif("exposure" not in bpy.types.Light.bl_rna.properties, reason="Blender 4.5 and later have it")
@pytest.mark.parametrize("kelvin", [2000.0, 6500.0])
def test_exposure_and_temperature(scene, kelvin):
    floor_below(scene, "square", exposure=1.5, use_temperature=True, temperature=kelvin, color=(0.9, 0.5, 0.3))
    assert_alike(scene)


@pytest.mark.parametrize("kelvin", [500.0, 800.0, 1200.0, 2700.0, 6500.0, 11000.0])
def test_blackbody_node(scene, kelvin):
    """Cycles has a fit of the same curve: within 0.3 % of the largest channel (seen: 0.17 %)."""
    light = floor_below(scene, "square")
    light.use_nodes = True
    tree = light.node_tree
    body = tree.nodes.new("ShaderNodeBlackbody")
    body.inputs["Temperature"].default_value = kelvin
    tree.links.new(body.outputs[0], tree.nodes["Emission"].inputs["Color"])
    ours = colour(render_with_penumbra(scene, 64)).mean((0, 1))
    assert statistics.last_render["warnings"] == []
    cycles = colour(render_with_cycles(scene, 64)).mean((0, 1))
    assert np.abs(ours - cycles).max() < 3e-3 * cycles.max()
