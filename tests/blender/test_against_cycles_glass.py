# SPDX-License-Identifier: GPL-3.0-or-later
"""Coloured transparent shadows against Cycles in the same Blender: constant, mixed, textured, layered, of all lights.

Tolerances: the mean of each channel within four of Cycles' noise and 0.3 %, the root mean square of the difference
within 1.7 of its noise (our own is in it, too).
"""

import bpy
import numpy as np
import pytest
from cycles_reference import colour, converge_cycles, relative_rmse, render_with_penumbra
from helpers import add_area_light, add_camera, add_plane, diffuse_material, link
from material_scenes import PRINCIPLED, Tree

SAMPLES = 256
AMBER, CYAN = (0.9, 0.4, 0.05), (0.1, 0.5, 0.8)


def transparent(t, tint):
    return t.add("ShaderNodeBsdfTransparent", {"Color": tint}).outputs[0]


def diffuse(t):
    return t.add("ShaderNodeBsdfDiffuse", {"Color": (0.2, 0.3, 0.9)}).outputs[0]


def mix(t, factor, first, second):
    return t.add("ShaderNodeMixShader", {0: factor, 1: first, 2: second}).outputs[0]


def checker(t):
    inputs = {"Vector": t.coordinates("Generated"), "Scale": 5.0, "Color1": AMBER, "Color2": CYAN}
    return t.add("ShaderNodeTexChecker", inputs).outputs["Color"]


def principled(t):
    """Alpha lets white light through; what is added tints."""
    solid = t.add(PRINCIPLED, {"Base Color": (0.8, 0.2, 0.2), "Alpha": 0.6}).outputs[0]
    return mix(t, 0.5, solid, transparent(t, AMBER))


GLASS = {
    "constant": lambda t: transparent(t, AMBER),
    "mixed": lambda t: mix(t, 0.7, diffuse(t), transparent(t, CYAN)),
    "textured": lambda t: transparent(t, checker(t)),
    "noise": lambda t: transparent(t, t.noise("Color", 2.0)),
    "principled": principled,
}
LIGHTS = {
    "area": lambda scene: add_area_light(scene, size=0.8, power=150.0, location=(1.2, -0.6, 3), rotation=(0.2, 0.4, 0)),
    "point": lambda scene: lamp(scene, "POINT", 120.0, shadow_soft_size=0.3),
    "sun": lambda scene: lamp(scene, "SUN", 3.0, angle=0.2),
    "world": lambda scene: sky(scene),
}


def lamp(scene, kind, energy, **values):
    light = bpy.data.lights.new("Lamp", kind)
    light.energy, light.color = energy, (1.0, 0.8, 0.6)
    for name, value in values.items():
        setattr(light, name, value)
    link(scene, "Lamp", light, location=(1.0, -0.6, 3.0), rotation=(0.2, 0.35, 0))


def sky(scene):
    world = scene.world = bpy.data.worlds.new("World")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs[0].default_value = (0.6, 0.8, 1.0, 1.0)


@pytest.fixture
def church(scene):
    """Two panes over a floor, one above the other in part; centre rays, so that edges are the same in both."""
    floor = add_plane(scene, "Floor", size=8.0)
    floor.data.materials.append(diffuse_material("Stone", (0.7, 0.7, 0.7)))
    for i in range(2):
        add_plane(
            scene, f"Pane {i}", size=1.4, location=(0.6 * i - 0.3, 0.3 * i, 0.7 + 0.3 * i), rotation=(0.2, 0.3, i)
        )
    add_camera(scene, location=(0, -4.5, 3.2), rotation=(0.95, 0, 0), lens=40)
    scene.render.resolution_x, scene.render.resolution_y = 48, 36
    scene.penumbra.pixel_samples = 1
    return scene


def assert_as_in_cycles(scene, material, light_samples=1024) -> None:
    for scene_object in scene.objects:
        if scene_object.name.startswith("Pane"):
            scene_object.data.materials.append(material)
    ours, (cycles, noise) = colour(render_with_penumbra(scene, light_samples)), converge_cycles(scene, SAMPLES)
    theirs = colour(cycles)
    difference = ours - theirs
    for channel in range(3):
        mean_noise = np.sqrt((noise[..., channel] ** 2).mean() / noise[..., 0].size)
        assert abs(difference[..., channel].mean()) < 4 * mean_noise + 3e-3 * theirs[..., channel].mean()
    assert relative_rmse(difference, theirs) < 1.7 * relative_rmse(noise, theirs) + 1e-3


@pytest.mark.parametrize("glass", GLASS.values(), ids=GLASS)
def test_kinds_of_glass(church, glass):
    LIGHTS["area"](church)
    tree = Tree("Glass")
    assert_as_in_cycles(church, tree.finish(glass(tree)))


@pytest.mark.parametrize("light", ["point", "sun", "world"])
def test_kinds_of_light(church, light):
    LIGHTS[light](church)
    tree = Tree("Glass")
    assert_as_in_cycles(church, tree.finish(transparent(tree, AMBER)))


def test_grey_glass_counts_no_channels(church):
    """Alpha from an image or a number, mixes with white: as many shadow rays as without any colour in sight."""
    from penumbra import statistics

    LIGHTS["area"](church)
    rays = {}
    for name, shader in (("alpha", lambda t: t.add(PRINCIPLED, {"Alpha": t.noise("Fac")}).outputs[0]),
                         ("mix", lambda t: mix(t, t.noise("Fac"), diffuse(t), transparent(t, (1, 1, 1)))),
                         ("tint", lambda t: mix(t, t.noise("Fac"), diffuse(t), transparent(t, AMBER)))):  # fmt: skip
        tree = Tree(name)
        material = tree.finish(shader(tree))
        for pane in (o for o in church.objects if o.name.startswith("Pane")):
            pane.data.materials.clear()
            pane.data.materials.append(material)
        render_with_penumbra(church, 16)
        rays[name] = statistics.last_render["shadow_rays"]
    assert rays["alpha"] == rays["mix"] < rays["tint"] / 2
