# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene where each pass has something to tell, its passes by the names of Blender 5, and both engines' pictures."""

import bpy
import numpy as np
from helpers import (
    add_area_light,
    add_camera,
    add_cube,
    add_plane,
    diffuse_material,
    emissive_material,
    render_pixels,
    use_cycles_as_reference,
)
from material_scenes import GLOSSY, Tree
from penumbra import compat

SWITCHES = {
    "Mist": "mist", "UV": "uv", "Object Index": "object_index", "Material Index": "material_index",
    "Diffuse Direct": "diffuse_direct", "Diffuse Color": "diffuse_color", "Glossy Direct": "glossy_direct",
    "Glossy Indirect": "glossy_indirect", "Glossy Color": "glossy_color", "Emission": "emit",
    "Environment": "environment", "Shadow": "shadow", "CryptoObject00": "cryptomatte_object",
    "CryptoMaterial00": "cryptomatte_material", "CryptoAsset00": "cryptomatte_asset",
}  # fmt: skip
"""The switches `use_pass_...` of a view layer by the pass's name."""

GROUPS = ("key", "rest")


def switch_on(layer, *names: str) -> None:
    for name in names or SWITCHES:
        setattr(layer, f"use_pass_{SWITCHES[name]}", True)


def shiny_material():
    """Diffuse and rough glossy, half of each, whose shares are exact in both engines."""
    tree = Tree("Shiny")
    diffuse = tree.add("ShaderNodeBsdfDiffuse", {"Color": (0.2, 0.5, 0.7)})
    glossy = tree.add(GLOSSY, {"Color": (0.9, 0.6, 0.3), "Roughness": 0.5}, distribution="GGX")
    mixed = tree.add("ShaderNodeMixShader", {0: 0.5, 1: diffuse.outputs[0], 2: glossy.outputs[0]})
    return tree.finish(mixed.outputs[0])


def glass_material():
    """Lets 60 % of the light through."""
    tree = Tree("Glass")
    diffuse = tree.add("ShaderNodeBsdfDiffuse", {"Color": (0.9, 0.1, 0.1)})
    clear = tree.add("ShaderNodeBsdfTransparent", {"Color": (1.0, 1.0, 1.0)})
    mixed = tree.add("ShaderNodeMixShader", {0: 0.6, 1: diffuse.outputs[0], 2: clear.outputs[0]})
    return tree.finish(mixed.outputs[0])


def mirror_material():
    tree = Tree("Mirror")
    return tree.finish(tree.add(GLOSSY, {"Color": (0.9, 0.8, 0.7), "Roughness": 0.0}).outputs[0])


def build(scene):
    """A floor with UV map, a shiny box and its child, a pane of glass, a lamp; two light groups and all passes on."""
    layer = scene.view_layers[0]
    switch_on(layer)
    layer.pass_cryptomatte_depth = 2
    for name in GROUPS:
        layer.lightgroups.add(name=name)
    floor = add_plane(scene, "Floor", size=6.0)
    floor.data.uv_layers.new(name="UVMap")
    box = add_cube(scene, "Box", size=0.9, location=(-0.8, 0.2, 0.46), rotation=(0, 0, 0.5))
    child = add_cube(scene, "Child", size=0.3, location=(0, 0, 0.61))
    child.parent = box
    pane = add_plane(scene, "Pane", size=1.2, location=(0.8, -0.6, 0.7), rotation=(1.2, 0, 0.2))
    lamp = add_plane(scene, "Lamp", size=0.9, location=(0.9, 1.2, 0.5), rotation=(1.3, 0, 0))
    materials = (diffuse_material("Matt", (0.7, 0.6, 0.5)), shiny_material(), shiny_material(), glass_material(),
                 emissive_material("Glow", (1.0, 0.8, 0.4), 2.0))  # fmt: skip
    for number, (thing, material) in enumerate(zip((floor, box, child, pane, lamp), materials, strict=True), 1):
        thing.data.materials.append(material)
        thing.pass_index, material.pass_index = number, 10 * number
    lamp.lightgroup = "rest"
    add_area_light(
        scene, "Key", size=1.0, power=80.0, location=(1.0, -1.0, 3.0), rotation=(0.3, 0.3, 0)
    ).lightgroup = "key"
    add_area_light(scene, "Rim", size=0.6, power=30.0, location=(-2, 1, 2), rotation=(0, -0.8, 0)).lightgroup = "rest"
    world = scene.world = bpy.data.worlds.new("World")
    world.use_nodes, world.lightgroup = True, "rest"
    world.node_tree.nodes["Background"].inputs[0].default_value = (0.1, 0.2, 0.4, 1.0)
    world.mist_settings.start, world.mist_settings.depth = 4.0, 6.0
    add_camera(scene, location=(0, -5.5, 3.2), rotation=(1.05, 0, 0), lens=38)
    return scene


def by_name(pixels: dict) -> dict[str, np.ndarray]:
    """The same passes by the native renderer's names, which are those of Blender 5; in double precision."""
    natives = {compat.pass_name(name): name for name in SWITCHES}
    return {natives.get(name, name): values.astype(float) for name, values in pixels.items()}


def penumbra_passes(scene) -> dict[str, np.ndarray]:
    return by_name(render_pixels(scene, "PENUMBRA"))


def cycles_passes(scene, samples: int, seed: int = 0, bounces: int = 0) -> dict[str, np.ndarray]:
    """bounces: off mirrors."""
    use_cycles_as_reference(scene, samples)
    scene.cycles.seed, scene.cycles.max_bounces = seed, bounces
    scene.cycles.glossy_bounces, scene.cycles.diffuse_bounces = bounces, 0
    return by_name(render_pixels(scene, "CYCLES"))
