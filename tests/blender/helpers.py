# SPDX-License-Identifier: GPL-3.0-or-later
"""What the tests inside Blender share: small scenes, renders read back as arrays, Blender run as another process."""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import bpy
import numpy as np
import OpenImageIO as oiio
import pytest
from penumbra import compat

REPOSITORY = Path(__file__).resolve().parents[2]
CHANNEL_ORDER = "RGBXYZWUVA"
HANGS_SECONDS = 600
"""After which another Blender is taken to hang; each ends in seconds on a machine with no other work."""


def read_exr(path) -> dict[str, np.ndarray]:
    """All passes of an EXR file: name -> (height, width, channels) float32, row 0 = bottom of the picture.

    A multilayer file with one view layer gives names such as "Depth"; with several, "ViewLayer.Depth". A plain EXR file
    gives "Combined".
    """
    groups: dict[tuple[str, str], list[tuple[int, np.ndarray]]] = {}
    for part in range(max(oiio.ImageBuf(str(path)).nsubimages, 1)):  # Blender 5.0+ writes a part for each pass
        image = oiio.ImageBuf(str(path), part, 0)
        spec = image.spec()
        pixels = image.get_pixels(oiio.FLOAT)
        if image.has_error or pixels is None:
            raise OSError(f"cannot read {path}: {image.geterror()}")
        pixels = np.asarray(pixels).reshape(spec.height, spec.width, spec.nchannels)[::-1]
        for index, channel in enumerate(spec.channelnames):
            layer, _, name = channel.rpartition(".")[0].partition(".")
            order = CHANNEL_ORDER.find(channel[-1].upper())
            groups.setdefault((layer, name or "Combined"), []).append((order, pixels[..., index]))
    one_layer = len({layer for layer, _ in groups}) == 1
    return {
        name if one_layer else f"{layer}.{name}": np.stack(
            [plane for _, plane in sorted(channels, key=lambda c: c[0])], -1
        )
        for (layer, name), channels in groups.items()
    }


def read_metadata(path) -> dict[str, object]:
    """The attributes in a picture's header."""
    return {attribute.name: attribute.value for attribute in oiio.ImageBuf(str(path)).spec().extra_attribs}


def make_lambertian(scene) -> None:
    """Gives what has no material the grey Lambertian one that it has before Blender 5.0 by itself."""
    if not compat.DEFAULT_SURFACE_IS_PRINCIPLED:
        return
    for scene_object in scene.objects:
        materials = getattr(scene_object.data, "materials", None)
        if materials is not None and not any(materials):
            materials.clear()
            materials.append(diffuse_material("Grey"))


def render_to_file(scene, engine: str, path, lambertian: bool = True) -> None:
    """Renders all passes of `scene` with `engine` into a 32-bit multilayer EXR; RuntimeError if the render fails.

    `lambertian`: what has no material is 80 % grey in any version, as most oracles want it.
    """
    prepare_render(scene, engine, lambertian)
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True, scene=scene.name)


def prepare_render(scene, engine: str, lambertian: bool = True) -> None:
    """Settings of render_to_file(), all but the path."""
    if lambertian:
        make_lambertian(scene)
    scene.render.engine = engine
    assert scene.render.engine == engine
    image = scene.render.image_settings
    compat.set_file_format(image, "OPEN_EXR_MULTILAYER")
    image.color_depth = "32"
    image.exr_codec = "NONE"
    scene.render.use_file_extension = False


def render_pixels(scene, engine: str = "PENUMBRA", lambertian: bool = True) -> dict[str, np.ndarray]:
    """Renders `scene` as render_to_file does: pass name -> (height, width, channels) float32, see read_exr."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "render.exr"
        render_to_file(scene, engine, path, lambertian)
        return read_exr(path)


def fails(scene, text: str) -> None:
    """Asserts that rendering `scene` is an error with this text in it."""
    with pytest.raises(RuntimeError, match=text):
        render_pixels(scene)


def set_raw(settings, name: str, value) -> None:
    """What a file may hold, made by another version of Penumbra or by hand, though no panel takes it."""
    get = getattr(settings, "bl_system_properties_get", None)  # Blender 5.0+
    (get(do_create=True) if get else settings)[name] = value


def use_cycles_as_reference(scene, samples: int = 64) -> None:
    """The settings under which a picture of Cycles may be compared with ours (docs: "Cycles" in a comparison)."""
    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.samples = samples
    cycles.max_bounces = 0
    cycles.light_sampling_threshold = 0.0
    cycles.blur_glossy = 0.0
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
    cycles.use_denoising = False
    cycles.use_adaptive_sampling = False
    cycles.pixel_filter_type = "GAUSSIAN"
    cycles.filter_width = 0.01
    for scene_object in scene.objects:
        for owner in (scene_object, getattr(scene_object, "cycles", None)):  # moved to the object in Blender 5
            for name in ("offset", "normal_offset", "shading_offset", "geometry_offset"):
                if hasattr(owner, f"shadow_terminator_{name}"):
                    setattr(owner, f"shadow_terminator_{name}", 0.0)


def link(scene, name: str, data, location=(0.0, 0.0, 0.0), rotation=(0.0, 0.0, 0.0), scale=(1.0, 1.0, 1.0)):
    """A new object of `data` in the scene's own collection; rotation in radians (XYZ)."""
    new_object = bpy.data.objects.new(name, data)
    new_object.location, new_object.rotation_euler, new_object.scale = location, rotation, scale
    scene.collection.objects.link(new_object)
    return new_object


def add_mesh(scene, name: str, vertices, faces, **transform):
    """An object with a new mesh of these vertices and faces."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([tuple(map(float, v)) for v in vertices], [], [tuple(f) for f in faces])
    mesh.update()
    return link(scene, name, mesh, **transform)


def add_plane(scene, name: str = "Plane", size: float = 2.0, **transform):
    """A square in the local xy plane, centred, facing +z; `size` is the side's length in metres."""
    h = size / 2
    return add_mesh(scene, name, [(-h, -h, 0), (h, -h, 0), (h, h, 0), (-h, h, 0)], [(0, 1, 2, 3)], **transform)


def add_cube(scene, name: str = "Cube", size: float = 2.0, **transform):
    """An axis-aligned cube, centred, normals outwards."""
    h = size / 2
    vertices = [(x, y, z) for z in (-h, h) for y in (-h, h) for x in (-h, h)]
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    return add_mesh(scene, name, vertices, faces, **transform)


def add_area_light(
    scene, name="Light", shape="SQUARE", size=1.0, size_y=None, power=100.0, color=(1, 1, 1), **transform
):
    """An area light emitting towards its local -z; power in Blender's watts, sizes in metres."""
    light = bpy.data.lights.new(name, "AREA")
    light.shape, light.size, light.energy, light.color = shape, size, power, color
    light.size_y = size if size_y is None else size_y
    return link(scene, name, light, **transform)


def add_light(scene, kind, name="Light", power=100.0, color=(1, 1, 1), data=None, **transform):
    """A light of any kind; `data`: further properties of it. Power in Blender's watts, a sun's in W/m^2."""
    light = bpy.data.lights.new(name, kind)
    light.energy, light.color = power, color
    for key, value in (data or {}).items():
        setattr(light, key, value)
    return link(scene, name, light, **transform)


def add_camera(scene, name="Camera", location=(0, 0, 5), rotation=(0, 0, 0), **settings):
    """The scene's camera, looking along its local -z; `settings` are properties of the camera's data."""
    camera = bpy.data.cameras.new(name)
    for key, value in settings.items():
        setattr(camera, key, value)
    scene.camera = link(scene, name, camera, location=location, rotation=rotation)
    return scene.camera


def animate(owner, name: str, values: dict) -> None:
    """Keys a property of an object or datablock at frames, with straight lines between them."""
    for frame, value in values.items():
        setattr(owner, name, value)
        owner.keyframe_insert(name, frame=frame)
    data = owner.animation_data
    if hasattr(data.action, "fcurves"):
        curves = data.action.fcurves
    else:  # Blender 5.0+
        curves = data.action.layers[0].strips[0].channelbag(data.action_slot).fcurves
    for point in (point for curve in curves for point in curve.keyframe_points):
        point.interpolation = "LINEAR"


def diffuse_material(name: str, color=(0.8, 0.8, 0.8)):
    """A material of one Diffuse BSDF (Lambert); colour is scene linear."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    output, diffuse = nodes.new("ShaderNodeOutputMaterial"), nodes.new("ShaderNodeBsdfDiffuse")
    diffuse.inputs["Color"].default_value = (*color, 1.0)
    diffuse.inputs["Roughness"].default_value = 0.0
    links.new(diffuse.outputs[0], output.inputs["Surface"])
    return material


def emissive_material(name: str, color=(1.0, 1.0, 1.0), strength=1.0):
    """A material of one Emission node."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    output, emission = nodes.new("ShaderNodeOutputMaterial"), nodes.new("ShaderNodeEmission")
    emission.inputs["Color"].default_value = (*color, 1.0)
    emission.inputs["Strength"].default_value = strength
    links.new(emission.outputs[0], output.inputs["Surface"])
    return material


def blender_program() -> str:
    """The program of the running Blender. The test is skipped where that is the module bpy, which has none."""
    if not bpy.app.binary_path:
        pytest.skip("the module bpy has no command line")
    return bpy.app.binary_path


def run_blender(
    *arguments, cwd=None, timeout=HANGS_SECONDS, environment=None, within=(), options=("-b",)
) -> subprocess.CompletedProcess:
    """Another `blender -b --factory-startup ARGUMENTS` with empty user folders; stdout and stderr as text.

    `environment`: variables to add, such as BLENDER_USER_SCRIPTS, a folder with addons/penumbra. `within`: a command
    that runs Blender, such as xvfb-run. `options`: what to have in place of -b.
    """
    with tempfile.TemporaryDirectory() as folder:
        variables = {"BLENDER_USER_CONFIG": folder, "BLENDER_USER_SCRIPTS": folder, "PYTHONDONTWRITEBYTECODE": "1"}
        return subprocess.run(
            [*map(str, within), blender_program(), *options, "--factory-startup", *map(str, arguments)],
            cwd=cwd, timeout=timeout, env={**os.environ, **variables, **(environment or {})},
            capture_output=True, text=True, errors="replace", check=False,
        )  # fmt: skip


def run_script(script, environment: dict | None = None) -> subprocess.CompletedProcess:
    """A Python script in another Blender (see run_blender), or in another Python where Blender is the module bpy."""
    if bpy.app.binary_path:
        return run_blender("--python-exit-code", "1", "-P", script, environment=environment)
    variables = {**os.environ, **(environment or {})}
    return subprocess.run(
        [sys.executable, script], timeout=HANGS_SECONDS, env=variables, capture_output=True, text=True,
        errors="replace", check=False,
    )  # fmt: skip


def command_line(addon: str, blend_file) -> list:
    """Arguments for Blender: enables the add-on and renders frame 1 with Penumbra into out_0001.exr beside the file."""
    output = blend_file.parent / "out_"
    return ["--addons", addon, blend_file, "-E", "PENUMBRA", "-o", output, "-F", "OPEN_EXR", "-f", "1"]


def last_line(process: subprocess.CompletedProcess) -> str:
    """The last line that a process wrote to stderr."""
    return process.stderr.strip().splitlines()[-1]
