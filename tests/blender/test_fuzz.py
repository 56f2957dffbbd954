# SPDX-License-Identifier: GPL-3.0-or-later
"""Random node trees and random scenes: a finite picture, or an error in a sentence; never an internal failure.

PENUMBRA_FUZZ_SECONDS=N goes on with other seeds for so long; a failure names its seed.
"""

import os
import time

import bpy
import numpy as np
import pytest
from helpers import add_area_light, add_camera, add_cube, add_mesh, add_plane, emissive_material, link, render_pixels

SECONDS = float(os.environ.get("PENUMBRA_FUZZ_SECONDS", 0))
FEW = 150
EXTREME = [0.0, -1.0, 1e-6, 1e6, 1e30, -1e30, float("nan"), float("inf")]


def number(random) -> float:
    return float(random.choice(EXTREME)) if random.random() < 0.1 else float(random.normal())


def assert_renders_or_refuses(scene, seed: int) -> None:
    try:
        for name, pixels in render_pixels(scene).items():
            assert np.isfinite(pixels).all(), f"seed {seed}: {name} is not finite"
    except RuntimeError as error:
        assert "Penumbra: " in str(error) and "internal failure" not in str(error), f"seed {seed}: {error}"


def seeds():
    """A few, always the same; or as many as fit into the time."""
    begin, seed = time.monotonic(), 0
    while seed < FEW or time.monotonic() - begin < SECONDS:
        yield seed
        seed += 1


def set_randomly(socket, random) -> None:
    """Any value into an input that has one."""
    value = getattr(socket, "default_value", None)
    if isinstance(value, (bool, int)) or value is None or isinstance(value, str):
        return
    try:
        socket.default_value = number(random) if isinstance(value, float) else [number(random) for _ in value]
    except (TypeError, ValueError):  # sockets of objects and images
        return


def random_tree(tree, random, kinds) -> None:
    """Some nodes of any kind, linked output to input at random, loops included as far as Blender lets them."""
    nodes = []
    for kind in random.choice(kinds, random.integers(1, 9)):
        try:
            nodes.append(tree.nodes.new(kind))
        except RuntimeError:  # an abstract kind
            continue
        for socket in nodes[-1].inputs:
            if random.random() < 0.5:
                set_randomly(socket, random)
    outputs = [socket for node in tree.nodes for socket in node.outputs]
    inputs = [socket for node in tree.nodes for socket in node.inputs]
    for _ in range(3 * len(nodes)):
        if outputs and inputs:
            tree.links.new(outputs[random.integers(len(outputs))], inputs[random.integers(len(inputs))])


@pytest.fixture
def small(scene):
    scene.render.resolution_x, scene.render.resolution_y = 16, 12
    scene.penumbra.stop_rule, scene.penumbra.light_samples = "FIXED", 4
    return scene


def test_random_node_trees(small):
    """In materials, a world and a light, of all of Blender's shader nodes."""
    kinds = sorted(name for name in dir(bpy.types) if name.startswith("ShaderNode") and name != "ShaderNodeTree")
    add_camera(small)
    planes = [add_plane(small, f"Plane {i}", location=(i - 1, 0, 0)) for i in range(3)]
    lamp = add_area_light(small, location=(0, 0, 4))
    lamp.data.use_nodes = True
    small.world = bpy.data.worlds.new("World")
    small.world.use_nodes = True
    for seed in seeds():
        random = np.random.default_rng(seed)
        for plane in planes:
            material = bpy.data.materials.new(f"Random {seed}")
            material.use_nodes = True
            if random.random() < 0.5:
                material.node_tree.nodes.clear()
                material.node_tree.nodes.new("ShaderNodeOutputMaterial")
            random_tree(material.node_tree, random, kinds)
            plane.data.materials.clear()
            plane.data.materials.append(material)
        if seed % 3 == 0:
            for owner in (lamp.data, small.world):
                random_tree(owner.node_tree, random, kinds)
        assert_renders_or_refuses(small, seed)
        for material in list(bpy.data.materials):
            bpy.data.materials.remove(material)


def random_object(scene, random, i: int) -> None:
    place = {key: [number(random) for _ in range(3)] for key in ("location", "rotation", "scale")}
    kind = random.integers(8)
    if kind == 6:
        glowing = add_cube(scene, f"Glowing {i}", **place)
        glowing.data.materials.append(
            emissive_material(f"Glow {i}", [number(random) for _ in range(3)], number(random))
        )
    elif kind == 7:
        carpet = add_plane(scene, f"Carpet {i}", **place)
        hair = carpet.modifiers.new("Hair", "PARTICLE_SYSTEM").particle_system.settings
        hair.type, hair.count, hair.hair_length = "HAIR", int(random.integers(20)), abs(number(random))
        hair.root_radius, hair.tip_radius, hair.radius_scale = (abs(number(random)) for _ in range(3))
    elif kind == 0:
        add_cube(scene, f"Cube {i}", **place)
    elif kind == 1:
        corners = [[number(random) for _ in range(3)] for _ in range(8)]
        faces = [random.choice(8, random.integers(3, 6), replace=False).tolist() for _ in range(random.integers(9))]
        made = add_mesh(scene, f"Mesh {i}", corners, faces, **place)
        made.data.validate() if random.random() < 0.5 else None
    elif kind == 2:
        light = bpy.data.lights.new(f"Light {i}", str(random.choice(["AREA", "POINT", "SPOT", "SUN"])))
        light.energy = 100 * number(random)
        for name in ("spot_blend", "spot_size", "shadow_soft_size", "angle", "spread"):
            if hasattr(light, name) and random.random() < 0.5:
                setattr(light, name, number(random))
        light.color = [abs(number(random)) for _ in range(3)]
        link(scene, f"Light {i}", light, **place)
    elif kind == 3:
        add_area_light(scene, f"Area {i}", str(random.choice(["SQUARE", "RECTANGLE", "DISK", "ELLIPSE"])),
                       abs(number(random)), abs(number(random)), 100 * number(random), **place)  # fmt: skip
    elif kind == 4:
        text = bpy.data.curves.new(f"Text {i}", "FONT")
        text.body, text.extrude = "Lux\n光", min(abs(number(random)), 1.0)
        link(scene, f"Text {i}", text, **place)
    else:
        cube = add_cube(scene, f"Modified {i}", **place)
        modifier = cube.modifiers.new("Any", str(random.choice(["BEVEL", "SUBSURF", "MIRROR", "SOLIDIFY", "ARRAY"])))
        if hasattr(modifier, "thickness"):
            modifier.thickness = number(random)


def add_motion(scene, random) -> None:
    """The frame is in the middle of what some objects do."""
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, abs(number(random))
    for moved in scene.objects:
        if random.random() < 0.5:
            continue
        for frame in (0, 2):
            for path in ("location", "rotation_euler", "scale"):
                setattr(moved, path, [number(random) for _ in range(3)])
                moved.keyframe_insert(path, frame=frame)
    scene.frame_set(1)


def random_world(random):
    """None, a colour, or a painted sky, some of whose pixels are not finite."""
    if random.random() < 0.3:
        return None
    world = bpy.data.worlds.new("World")
    world.use_nodes = True
    background = world.node_tree.nodes["Background"]
    set_randomly(background.inputs["Color"], random)
    set_randomly(background.inputs["Strength"], random)
    if random.random() < 0.6:
        picture = bpy.data.images.new("Sky", 8, 4, float_buffer=True)
        picture.pixels.foreach_set(np.array([number(random) for _ in range(8 * 4 * 4)], np.float32))
        texture = world.node_tree.nodes.new("ShaderNodeTexEnvironment")
        texture.image = picture
        world.node_tree.links.new(texture.outputs["Color"], background.inputs["Color"])
    return world


def test_random_scenes(small):
    """Objects, lights, worlds and cameras of all kinds at any place, some of it not finite."""
    rules = ["BOUNDED", "FIXED", "PAPER", "VARIANCE"]
    for seed in seeds():
        random = np.random.default_rng(seed)
        for i in range(random.integers(1, 8)):
            random_object(small, random, i)
        camera = add_camera(small, location=(0, 0, 6), type=str(random.choice(["PERSP", "ORTHO"])))
        if random.random() < 0.2:
            camera.location.x = number(random)
            camera.data.dof.use_dof = True
            camera.data.dof.aperture_fstop, camera.data.dof.focus_distance = number(random), number(random)
        if random.random() < 0.3:
            add_motion(small, random)
        small.world = random_world(random)
        small.penumbra.stop_rule = str(random.choice(rules))
        small.penumbra.max_light_samples = 64
        small.penumbra.pixel_samples = int(random.integers(1, 4))
        small.penumbra.max_pixel_samples = 64
        assert_renders_or_refuses(small, seed)
        for made in list(small.objects):
            bpy.data.objects.remove(made)
        small.render.use_motion_blur = False
        bpy.data.orphans_purge()
