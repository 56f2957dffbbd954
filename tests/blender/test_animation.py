# SPDX-License-Identifier: GPL-3.0-or-later
"""Frames of an animation with persistent data, which re-use the meshes that did not change.

The oracle is each frame rendered by itself without persistent data, where nothing is kept. Kept meshes are traced in a
space of their own, so pictures agree within rounding but where a ray grazes an edge.
"""

import os
from pathlib import Path

import bpy
import numpy as np
import OpenImageIO as oiio
import pytest
from helpers import add_cube, add_mesh, add_plane, animate, link, make_lambertian, read_exr, render_pixels
from penumbra import compat, engine
from penumbra.export import Kept

FRAMES = range(1, 5)
GRAZING = 0.01
"""Share of the pixels whose ray may meet another edge, or see another of 64 points, by rounding"""


def prepare(scene) -> None:
    scene.penumbra.stop_rule, scene.penumbra.light_samples = "FIXED", 64
    scene.frame_start, scene.frame_end = FRAMES[0], FRAMES[-1]
    add_plane(scene, "Floor", size=20)


def render_animation(scene, folder: Path) -> dict[int, dict[str, np.ndarray]]:
    """All frames in one run of Blender's, with persistent data, of the materials that render_pixels renders."""
    make_lambertian(scene)
    compat.set_file_format(scene.render.image_settings, "OPEN_EXR_MULTILAYER")
    scene.render.image_settings.color_depth = "32"
    scene.render.filepath, scene.render.use_file_extension = str(folder / "frame_"), True
    scene.render.use_persistent_data = True
    bpy.ops.render.render(animation=True, scene=scene.name)
    return {
        frame: read_exr(folder / f"frame_{frame:04d}.exr") for frame in range(scene.frame_start, scene.frame_end + 1)
    }


def render_single_frames(scene) -> dict[int, dict[str, np.ndarray]]:
    scene.render.use_persistent_data = False
    found = {}
    for frame in FRAMES:
        scene.frame_set(frame)
        found[frame] = render_pixels(scene)
    return found


def differing(a, b) -> float:
    """Share of the pixels that differ in colour or depth by more than rounding."""
    scale = max(b["Combined"].max(), 1e-9)
    off = abs(a["Combined"] - b["Combined"]).max(axis=-1) > 1e-4 * scale
    depth = abs(a["Depth"] - b["Depth"])[..., 0] > 1e-4 * b["Depth"][..., 0]
    return float(np.mean(off | depth))


class Recorded(Kept):
    """A Kept that tells which of a frame's meshes it had already."""

    frames: list = []

    def end(self) -> None:
        before = {id(mesh) for mesh in self._alive if mesh}
        found = {mesh.name: id(mesh) in before for mesh in self._now.values() if mesh}
        Recorded.frames.append(found)
        super().end()


@pytest.fixture
def reused(monkeypatch):
    """For each frame: name of the object a mesh was first seen at -> whether it was kept from the frame before."""
    Recorded.frames = []
    monkeypatch.setattr(engine, "Kept", Recorded)
    return Recorded.frames


def moving(scene):
    cube = add_cube(scene, "Thing", size=1, location=(-1, 0, 1))
    animate(cube, "location", {FRAMES[0]: (-1.5, 0, 1), FRAMES[-1]: (1.5, 0.5, 1)})


def turning_camera(scene):
    add_cube(scene, "Thing", size=1, location=(0.5, 0, 1))
    animate(scene.camera, "location", {FRAMES[0]: (0, 0, 10), FRAMES[-1]: (2, 1, 10)})


def brightening_light(scene):
    add_cube(scene, "Thing", size=1, location=(0.5, 0, 1))
    light = next(o for o in scene.objects if o.type == "LIGHT")
    animate(light.data, "energy", {FRAMES[0]: 50.0, FRAMES[-1]: 200.0})


def armature(scene):
    data = bpy.data.armatures.new("Bones")
    rig = link(scene, "Rig", data)
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    bone = data.edit_bones.new("Bone")
    bone.head, bone.tail = (0, 0, 0), (0, 0, 1)
    bpy.ops.object.mode_set(mode="OBJECT")
    thing = add_cube(scene, "Thing", size=1, location=(0, 0, 1))
    thing.vertex_groups.new(name="Bone").add(range(8), 1.0, "REPLACE")
    thing.modifiers.new("Armature", "ARMATURE").object = rig
    pose = rig.pose.bones["Bone"]
    pose.rotation_mode = "XYZ"
    for frame, angle in ((FRAMES[0], 0.0), (FRAMES[-1], 1.0)):
        pose.rotation_euler = (0, 0, angle)
        pose.keyframe_insert("rotation_euler", frame=frame)


def shape_keys(scene):
    thing = add_cube(scene, "Thing", size=1, location=(0, 0, 1))
    thing.shape_key_add(name="Basis")
    key = thing.shape_key_add(name="Wide")
    for point in key.data:
        point.co = (2 * point.co.x, point.co.y, point.co.z)
    for frame, value in ((FRAMES[0], 0.0), (FRAMES[-1], 1.0)):
        key.value = value
        key.keyframe_insert("value", frame=frame)


def changing_topology(scene):
    thing = add_cube(scene, "Thing", size=0.5, location=(-1.5, 0, 1))
    array = thing.modifiers.new("Array", "ARRAY")
    array.relative_offset_displace = (1.5, 0, 0)
    for frame, count in zip(FRAMES, (1, 3, 2, 4), strict=True):
        array.count = count
        array.keyframe_insert("count", frame=frame)


def visibility(scene):
    thing = add_cube(scene, "Thing", size=1, location=(0.5, 0, 1))
    for frame, hidden in zip(FRAMES, (False, True, False, True), strict=True):
        thing.hide_render = hidden
        thing.keyframe_insert("hide_render", frame=frame)


def particles(scene):
    add_cube(scene, "Dust", size=0.15, location=(30, 30, 0))
    emitter = add_plane(scene, "Thing", size=3, location=(0, 0, 2))
    settings = emitter.modifiers.new("Particles", "PARTICLE_SYSTEM").particle_system.settings
    settings.count, settings.frame_start, settings.frame_end, settings.lifetime = 100, 1, 4, 50
    settings.render_type, settings.instance_object, settings.particle_size = "OBJECT", bpy.data.objects["Dust"], 1.0
    emitter.show_instancer_for_render = False


def geometry_nodes(scene):
    """A ball at each corner of a square, each frame larger."""
    thing = add_plane(scene, "Thing", size=3, location=(0, 0, 1))
    tree = bpy.data.node_groups.new("Balls", "GeometryNodeTree")
    if hasattr(tree, "interface"):
        tree.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
        tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    else:
        tree.inputs.new("NodeSocketGeometry", "Geometry")
        tree.outputs.new("NodeSocketGeometry", "Geometry")
    group_in, group_out = tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")
    placed, ball = tree.nodes.new("GeometryNodeInstanceOnPoints"), tree.nodes.new("GeometryNodeMeshIcoSphere")
    ball.inputs["Radius"].default_value, ball.inputs["Subdivisions"].default_value = 0.3, 3
    size = tree.nodes.new("ShaderNodeValue")
    tree.links.new(group_in.outputs[0], placed.inputs["Points"])
    tree.links.new(ball.outputs["Mesh"], placed.inputs["Instance"])
    tree.links.new(size.outputs[0], placed.inputs["Scale"])
    tree.links.new(placed.outputs["Instances"], group_out.inputs[0])
    thing.modifiers.new("Balls", "NODES").node_group = tree
    animate_socket = size.outputs[0]
    for frame, value in ((FRAMES[0], 0.5), (FRAMES[-1], 1.5)):
        animate_socket.default_value = value
        animate_socket.keyframe_insert("default_value", frame=frame)


DEFORMING = {armature, shape_keys, changing_topology}
CASES = [moving, turning_camera, brightening_light, visibility, particles, geometry_nodes, *DEFORMING]


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.__name__)
def test_each_frame_is_as_if_rendered_alone(lit_scene, tmp_path, reused, case):
    prepare(lit_scene)
    case(lit_scene)
    frames, alone = render_animation(lit_scene, tmp_path), render_single_frames(lit_scene)
    assert len(reused) == len(FRAMES), "each frame of the animation, and no single one, keeps its meshes"
    for frame in FRAMES:
        assert differing(frames[frame], alone[frame]) < GRAZING, frame
    for one, other in zip(FRAMES, FRAMES[1:], strict=False):
        assert differing(alone[one], alone[other]) > 1.5 * GRAZING, "the animation shows"
    assert not any(reused[0].values())
    for before, found in zip(reused, reused[1:], strict=False):
        assert found["Floor"]
        if "Thing" in found:  # what a frame has not is let go of
            assert found["Thing"] == (case not in DEFORMING and "Thing" in before)


def test_without_persistent_data_nothing_is_kept(lit_scene, tmp_path, reused):
    prepare(lit_scene)
    moving(lit_scene)
    render_pixels(lit_scene)
    assert reused == []
    render_animation(lit_scene, tmp_path)
    assert reused[-1]["Thing"] and reused[-1]["Floor"]
    lit_scene.render.use_persistent_data = False
    render_pixels(lit_scene)
    assert len(reused) == len(FRAMES)


def resident_mebibytes() -> float:
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * 4096 / 2**20


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="needs /proc")
@pytest.mark.parametrize("persistent", [False, True], ids=["alone", "persistent"])
def test_memory_does_not_grow_over_a_hundred_frames(lit_scene, tmp_path, persistent):
    """A deforming mesh of 20,000 triangles beside one that stays: what a frame makes is about 3 MiB, so that keeping it
    would show as 240 MiB over the last 80 frames. A tenth of that is left to allocators."""
    prepare(lit_scene)
    side = np.linspace(-2, 2, 101)
    x, y = (a.ravel() for a in np.meshgrid(side, side))
    corner = (np.arange(100)[:, None] * 101 + np.arange(100)).ravel()
    faces = np.stack([corner, corner + 1, corner + 102, corner + 101], axis=-1)
    for name, height in (("Waves", 0.5), ("Still", 0.2)):
        thing = add_mesh(lit_scene, name, np.stack([x, y, np.full_like(x, height)], axis=-1), faces)
        if name == "Waves":
            thing.modifiers.new("Wave", "WAVE")
    lit_scene.frame_end = 100
    lit_scene.penumbra.light_samples = 4
    lit_scene.render.use_persistent_data = persistent
    lit_scene.render.resolution_x, lit_scene.render.resolution_y = 16, 12
    lit_scene.render.filepath = str(tmp_path / "frame_")
    after: list[float] = []

    def measure(*_):
        after.append(resident_mebibytes())

    bpy.app.handlers.render_post.append(measure)
    try:
        bpy.ops.render.render(animation=True, scene=lit_scene.name)
    finally:
        bpy.app.handlers.render_post.remove(measure)
    assert len(after) == 100
    assert after[-1] - after[19] < 24


def test_textures_stay_until_their_file_changes(lit_scene, tmp_path):
    """A file that changes behind its back, its time of change put back, shows as before: its pixels were kept. With
    another time it is read again."""
    path = tmp_path / "colour.png"

    def save(colour) -> None:
        """Not by an image of Blender's: Blender 5 crashes where a handler adds and removes one between frames."""
        image = oiio.ImageBuf(oiio.ImageSpec(4, 4, 3, oiio.UINT8))
        oiio.ImageBufAlgo.fill(image, colour)
        assert image.write(str(path)), image.geterror()

    save((1, 0, 0))
    floor = add_plane(lit_scene, "Floor", size=20)
    material = bpy.data.materials.new("Textured")
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    output, diffuse, texture = (
        nodes.new(f"ShaderNode{name}") for name in ("OutputMaterial", "BsdfDiffuse", "TexImage")
    )
    texture.image = bpy.data.images.load(str(path))
    links.new(texture.outputs["Color"], diffuse.inputs["Color"])
    links.new(diffuse.outputs[0], output.inputs["Surface"])
    floor.data.materials.append(material)
    times = path.stat()

    def save_behind_its_back(colour, later: int = 0) -> None:
        save(colour)
        os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns + later * 10**9))

    # after each frame
    changes = [lambda: save_behind_its_back((0, 1, 0)), lambda: save_behind_its_back((0, 1, 0), later=1),
               lambda: save_behind_its_back((1, 0, 0), later=1), lambda: None]  # fmt: skip

    def change(*_):
        changes.pop(0)()

    lit_scene.frame_end = len(changes)
    bpy.app.handlers.render_post.append(change)
    try:
        frames = render_animation(lit_scene, tmp_path)
    finally:
        bpy.app.handlers.render_post.remove(change)
    colours = [frame["Combined"][..., :3].mean(axis=(0, 1)) for frame in frames.values()]
    assert all(colour.max() > 0.05 and sorted(colour)[1] < 1e-3 for colour in colours)
    assert [int(colour.argmax()) for colour in colours] == [0, 0, 1, 1]
    lit_scene.render.use_persistent_data = False
    assert render_pixels(lit_scene)["Combined"][..., :3].mean(axis=(0, 1)).argmax() == 0
