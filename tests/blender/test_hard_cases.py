# SPDX-License-Identifier: GPL-3.0-or-later
"""The rows of the catalogue of hard cases in which Blender has a say (the others: tests/hard_cases): what cannot be
rendered is an error that names its object; odd but legal scenes render."""

import struct
import zlib

import bpy
import numpy as np
import pytest
from helpers import (
    add_area_light,
    add_camera,
    add_cube,
    add_light,
    add_mesh,
    add_plane,
    emissive_material,
    link,
    render_pixels,
    set_raw,
)
from penumbra import native, statistics


def fails(scene, text: str) -> None:
    with pytest.raises(RuntimeError, match=text):
        render_pixels(scene)


def test_d40_no_camera(scene):
    fails(scene, "no camera")  # Blender's own check comes first


def test_panoramic_camera(scene):
    add_camera(scene, "Fisheye", type="PANO")
    fails(scene, "camera 'Fisheye': pano cameras are not supported")


def test_a_lamp_as_camera(scene):
    scene.camera = link(scene, "Lamp", bpy.data.lights.new("Lamp", "AREA"))
    fails(scene, "camera 'Lamp' is no camera")


@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_d41_camera_at_no_place(scene, value):
    add_camera(scene, "Lost").matrix_world[0][3] = value
    fails(scene, "camera 'Lost': its position or rotation is not a finite number")


@pytest.mark.parametrize(
    ("settings", "text"),
    [
        ({"clip_start": 5.0, "clip_end": 2.0}, "clip start 5 m is not below clip end 2 m"),
        ({"clip_start": 2.0, "clip_end": 2.0}, "clip start 2 m is not below clip end 2 m"),
    ],
)
def test_d41_degenerate_cameras(scene, settings, text):
    add_camera(scene, "Odd", **settings)
    fails(scene, f"camera 'Odd': .*{text}")


def test_d41_orthographic_scale_of_zero(scene):
    add_camera(scene, "Odd", type="ORTHO", ortho_scale=0.0)
    if bpy.app.version < (5, 0, 0):
        fails(scene, "camera 'Odd': .* leaves nothing to see")
    else:  # Blender sees a nanometre then
        assert np.isfinite(render_pixels(scene)["Combined"]).all()


def test_d41_camera_of_no_scale(scene):
    add_camera(scene, "Flat").scale = (1, 0, 1)
    fails(scene, "camera 'Flat': its scale is zero")


def test_stereoscopy(scene):
    add_camera(scene)
    scene.render.use_multiview = True
    fails(scene, "camera 'Camera': stereoscopy")


def test_d36_a_vertex_that_is_no_number_names_the_object(lit_scene):
    broken = add_mesh(lit_scene, "Broken mesh", [(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)])
    broken.data.vertices[1].co.x = float("nan")
    fails(lit_scene, "Broken mesh: vertex 1 is not finite")


def test_settings_that_do_not_fit_are_both_named(lit_scene):
    lit_scene.penumbra.sampler, lit_scene.penumbra.stop_rule = "SPRS", "PAPER"
    fails(lit_scene, "(?s)SPRS.*stop_rule")
    lit_scene.penumbra.stop_rule, lit_scene.penumbra.light_samples = "FIXED", 60
    fails(lit_scene, "(?s)SPRS.*light_samples")


def test_d47_names_with_odd_characters(lit_scene):
    name = "Ünï 'quoted'\nline %s {x} 光"
    broken = add_mesh(lit_scene, name, [(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)])
    render_pixels(lit_scene)
    broken.data.vertices[1].co.x = float("nan")
    fails(lit_scene, "(?s)Ünï 'quoted'\nline %s {x} 光")


def test_an_unexpected_failure_is_an_error_too(lit_scene, monkeypatch):
    class Broken:
        def Scene(self):  # noqa: N802
            raise ZeroDivisionError("on purpose")

    monkeypatch.setattr(native, "module", Broken())
    fails(lit_scene, "internal failure: ZeroDivisionError: on purpose")


def test_a_worker_that_fails_is_an_error(lit_scene, monkeypatch):
    class Failing:
        """A render whose threads fail after a few buckets, as after an error inside Embree."""

        def __init__(self, render):
            self._render = render

        def __getattr__(self, name):
            return getattr(self._render, name)

        def finish(self):
            self._render.finish()
            raise RuntimeError("embree: out of memory")

    class Module:
        def __getattr__(self, name):
            return getattr(real, name)

        def Render(self, *arguments):  # noqa: N802
            return Failing(real.Render(*arguments))

    real = native.module
    monkeypatch.setattr(native, "module", Module())
    fails(lit_scene, "embree: out of memory")


def test_d40_an_empty_scene_is_its_background(scene):
    add_camera(scene)
    scene.world = bpy.data.worlds.new("World")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.25, 0.5, 1, 1)
    pixels = render_pixels(scene)["Combined"]
    np.testing.assert_allclose(pixels, np.broadcast_to([0.25, 0.5, 1, 1], pixels.shape))


def test_d40_no_lights_are_black(scene):
    add_camera(scene)
    add_plane(scene)
    assert not render_pixels(scene)["Combined"][..., :3].any()


@pytest.mark.parametrize("size", [(4, 4), (5, 300), (300, 5), (65, 63)])
def test_d45_odd_sizes(lit_scene, size):
    add_cube(lit_scene)
    lit_scene.render.resolution_x, lit_scene.render.resolution_y = size
    assert render_pixels(lit_scene)["Combined"].shape == (size[1], size[0], 4)


def test_d42_camera_inside_an_object(lit_scene):
    add_cube(lit_scene, size=40)
    assert np.isfinite(render_pixels(lit_scene)["Combined"]).all()


def test_a16_a_light_of_no_size_is_named_in_a_note(lit_scene):
    add_plane(lit_scene)
    lit_scene.objects["Light"].data.size = 0
    assert not render_pixels(lit_scene)["Combined"][..., :3].any()
    assert any("light 'Light': its area is zero" in note for note in statistics.last_render["warnings"])


@pytest.mark.parametrize("place", [0, 2**10, 2**20, 2**23])
def test_c31_places_that_float32_holds(scene, place):
    """Blender's matrices are float32: at multiples of a metre up to 2^23 m it knows them exactly, and the picture is
    that at the origin but for rounding in the camera's window, which moves single points across the cube's edges."""
    pictures = []
    for x in (0, place):
        for name in ("Floor", "Box", "Sun", "Eye"):
            if name in scene.objects:
                bpy.data.objects.remove(scene.objects[name])
        add_plane(scene, "Floor", size=32, location=(x, -x, 0))
        add_cube(scene, "Box", size=2, location=(x, -x, 1))
        add_area_light(scene, "Sun", size=2.0, power=400, location=(x + 3, -x, 6))
        add_camera(scene, "Eye", location=(x, -x, 16), type="ORTHO", ortho_scale=8.0)
        pictures.append(render_pixels(scene)["Combined"][..., 0])
    assert (np.abs(pictures[1] - pictures[0]) > 1e-3 * pictures[0].max()).mean() <= 0.01
    assert pictures[0].min() < 0.5 * pictures[0].max()


def test_d37_faces_without_area_are_counted_and_named(lit_scene):
    add_plane(lit_scene, size=20)
    add_mesh(lit_scene, "Sliver", [(0, 0, 1), (1, 0, 1), (2, 0, 1), (0, 0, 1)], [(0, 1, 2), (0, 1, 3)])
    assert np.isfinite(render_pixels(lit_scene)["Combined"]).all()
    assert "2 triangles without area were left out: 'Sliver'" in statistics.last_render["warnings"]


def test_d39_scale_zero_is_counted_and_named(lit_scene):
    add_plane(lit_scene, size=20)
    add_cube(lit_scene, "Flat", scale=(1, 0, 1))
    render_pixels(lit_scene)
    notes = statistics.last_render["warnings"]
    assert "1 objects whose scale is zero in some direction were left out: 'Flat'" in notes


def test_d39_hair_on_an_object_of_scale_zero_is_named(lit_scene):
    """Found by fuzzing: an internal failure."""
    add_plane(lit_scene, size=20)
    fur = add_plane(lit_scene, "Fur", scale=(1, 0, 1)).modifiers.new("Hair", "PARTICLE_SYSTEM").particle_system.settings
    fur.type, fur.count = "HAIR", 10
    assert np.isfinite(render_pixels(lit_scene)["Combined"]).all()
    notes = statistics.last_render["warnings"]
    assert "object 'Fur': its scale is zero in some direction, so it has no hair" in notes


def test_d45_an_empty_border(lit_scene):
    """Blender refuses it before the engine is asked."""
    render = lit_scene.render
    render.use_border, render.border_min_x, render.border_max_x = True, 0.5, 0.5
    fails(lit_scene, "too small")


def test_d49_a_stack_of_identical_faces(lit_scene):
    """50,000 squares at one place: modelling accidents do that. Rendered at once, counted and named."""
    corners = [(-9, -9, 0), (9, -9, 0), (9, 9, 0), (-9, 9, 0)]
    faces = [tuple(range(i, i + 4)) for i in range(0, 200_000, 4)]
    add_mesh(lit_scene, "Stack", corners * 50_000, faces)
    picture = render_pixels(lit_scene)["Combined"]
    assert picture[..., :3].min() > 0
    text = "99998 triangles that are copies of others were left out: 'Stack'"
    assert text in statistics.last_render["warnings"]


@pytest.mark.parametrize("degrees", [180, 90, 1])
def test_a19_spread(scene, degrees):
    """From the whole hemisphere to a beam, the narrowest Blender has included: finite, without a note, and the narrower
    the brighter straight below the light, since its power stays the same (test_against_cycles_points.py has figures).
    """
    add_plane(scene, size=20)
    add_camera(scene, location=(0, 0, 3))
    light = add_area_light(scene, "Lamp", location=(0, 0, 4)).data
    widest = render_pixels(scene)["Combined"][..., 0]
    light.spread = np.radians(degrees)
    picture = render_pixels(scene)["Combined"][..., 0]
    assert np.isfinite(picture).all() and not statistics.last_render["warnings"]
    below = picture.shape[0] // 2, picture.shape[1] // 2
    assert picture[below] > 1.2 * widest[below] if degrees < 180 else (picture == widest).all()


NAN, INFINITY = float("nan"), float("inf")


@pytest.mark.parametrize(
    ("kind", "values", "what"),
    [(kind, {"energy": value}, "power") for kind in ("AREA", "POINT", "SPOT", "SUN") for value in (NAN, INFINITY)]
    + [(kind, {"color": (1, NAN, 1)}, "colour") for kind in ("AREA", "POINT", "SPOT", "SUN")]
    + [
        ("SPOT", {"spot_blend": NAN}, "cone"),
        ("SPOT", {"spot_size": NAN}, "cone"),
        ("SPOT", {"shadow_soft_size": NAN}, "radius"),
        ("POINT", {"shadow_soft_size": NAN}, "radius"),
        ("SUN", {"angle": NAN}, "angle"),
        ("AREA", {"spread": NAN}, "spread"),
        ("AREA", {"size": NAN}, "size"),
    ],
)
def test_a17_lights_of_every_kind_that_are_no_numbers_are_named(scene, kind, values, what):
    add_plane(scene)
    add_camera(scene)
    light = add_light(scene, kind, "Lampe\n2", location=(0, 0, 3)).data
    for name, value in values.items():
        setattr(light, name, value)
    fails(scene, f"light 'Lampe\\\\n2': its {what} is not a finite number")


@pytest.mark.parametrize("values", [{"strength": NAN}, {"color": (NAN, 1, 1)}])
def test_a17_glowing_meshes_that_are_no_numbers_are_named(lit_scene, values):
    add_cube(lit_scene).data.materials.append(emissive_material("Glut", **values))
    fails(lit_scene, "material 'Glut': a value of its nodes is not a finite number")


@pytest.mark.parametrize("pixel", [NAN, INFINITY])
def test_a17_a_painted_sky_that_is_no_numbers_is_named(lit_scene, pixel):
    background = sky(lit_scene, "Himmel")
    picture = bpy.data.images.new("Sky", 8, 4, float_buffer=True)
    picture.pixels.foreach_set(np.where(np.arange(8 * 4 * 4) == 20, pixel, 1).astype(np.float32))
    tree = lit_scene.world.node_tree
    texture = tree.nodes.new("ShaderNodeTexEnvironment")
    texture.image = picture
    tree.links.new(texture.outputs["Color"], background.inputs["Color"])
    fails(lit_scene, "world 'Himmel': the picture has pixels that are not finite")


def test_a17_a_sky_of_a_strength_that_is_no_number_is_named(lit_scene):
    sky(lit_scene, "Himmel").inputs["Strength"].default_value = NAN
    fails(lit_scene, "world 'Himmel': its colour or strength is not a finite number")


def sky(scene, name):
    """Its Background node."""
    scene.world = bpy.data.worlds.new(name)
    scene.world.use_nodes = True
    return scene.world.node_tree.nodes["Background"]


def shaders(scene, name):
    """A floor's node tree with nothing but the output, and that node's Surface."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    material.node_tree.nodes.clear()
    add_plane(scene, size=20).data.materials.append(material)
    return material.node_tree, material.node_tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"]


def added_to_itself(tree, surface, times):
    last = tree.nodes.new("ShaderNodeBsdfDiffuse").outputs[0]
    for _ in range(times):
        node = tree.nodes.new("ShaderNodeAddShader")
        tree.links.new(last, node.inputs[0])
        tree.links.new(last, node.inputs[1])
        last = node.outputs[0]
    tree.links.new(last, surface)


def test_d43_shaders_that_are_added_to_themselves(lit_scene):
    """2^40 ways through 40 nodes would never end; 2^3 are followed: eight times the light, at most."""
    tree, surface = shaders(lit_scene, "Doubled")
    added_to_itself(tree, surface, 3)
    assert np.isfinite(render_pixels(lit_scene)["Combined"]).all()
    tree, surface = shaders(lit_scene, "Doubled for ever")
    added_to_itself(tree, surface, 40)
    fails(lit_scene, "material 'Doubled for ever': its nodes join shaders in more than 2048 ways")


@pytest.mark.parametrize("into", ["ShaderNodeMixShader", "ShaderNodeBsdfDiffuse"])
def test_d43_a_colour_for_a_number_and_a_number_for_a_colour(lit_scene, into):
    """Blender converts: the mean by luminance, and grey. As with plain values; fuzzing found an internal failure."""
    pictures = []
    for linked in (False, True):
        tree, surface = shaders(lit_scene, f"Converted {linked}")
        diffuse = tree.nodes.new("ShaderNodeBsdfDiffuse")
        diffuse.inputs["Color"].default_value = (0.3, 0.3, 0.3, 1)
        tree.links.new(diffuse.outputs[0], surface)
        source = tree.nodes.new("ShaderNodeRGB" if into == "ShaderNodeMixShader" else "ShaderNodeValue").outputs[0]
        source.default_value = (0.3, 0.3, 0.3, 1) if into == "ShaderNodeMixShader" else 0.3
        if into == "ShaderNodeMixShader":
            mix, black = tree.nodes.new(into), tree.nodes.new("ShaderNodeBsdfDiffuse")
            black.inputs["Color"].default_value = (0, 0, 0, 1)
            mix.inputs[0].default_value = 0.3
            for a, b in ((black.outputs[0], mix.inputs[1]), (diffuse.outputs[0], mix.inputs[2])):
                tree.links.new(a, b)
            tree.links.new(mix.outputs[0], surface)
        if linked:
            tree.links.new(source, (mix if into == "ShaderNodeMixShader" else diffuse).inputs[0])
        pictures.append(render_pixels(lit_scene)["Combined"])
        for made in [one for one in lit_scene.objects if one.type == "MESH"]:
            bpy.data.objects.remove(made)
    np.testing.assert_allclose(pictures[1], pictures[0], rtol=1e-5)
    assert pictures[0][..., 0].max() > 0


def test_d43_nodes_in_a_long_row(lit_scene):
    """Longer than Python's stack."""
    tree, surface = shaders(lit_scene, "Row")
    emission = tree.nodes.new("ShaderNodeEmission")
    tree.links.new(emission.outputs[0], surface)
    last = tree.nodes.new("ShaderNodeRGB").outputs[0]
    for _ in range(500):
        node = tree.nodes.new("ShaderNodeInvert")
        tree.links.new(last, node.inputs["Color"])
        last = node.outputs[0]
    tree.links.new(last, emission.inputs["Color"])
    fails(lit_scene, "material 'Row': too many of its nodes are linked in a row")


@pytest.mark.parametrize(
    ("name", "value"),
    [("error_tolerance", NAN), ("error_tolerance", -1.0), ("light_samples", -5),
     ("max_light_samples", 0), ("pixel_samples", -1), ("filter_width", NAN), ("mirror_depth", -7),
     ("memory_limit", -9), ("check_interval", 0)],
)  # fmt: skip
def test_d46_settings_of_a_hostile_file(lit_scene, name, value):
    """What a .blend can hold though no panel takes it: an error that names the setting. A choice of another version of
    Penumbra is none: it falls back to the default."""
    set_raw(lit_scene.penumbra, name, value)
    if lit_scene.penumbra.stop_rule == "BOUNDED" and name in ("light_samples", "check_interval"):
        lit_scene.penumbra.stop_rule = "PAPER" if name == "check_interval" else "FIXED"
    fails(lit_scene, name)


@pytest.mark.parametrize("name", ["stop_rule", "sampler", "sample_reuse", "filter_type"])
@pytest.mark.parametrize("number", [-1, 99])
def test_d46_choices_of_a_hostile_file_become_the_default(lit_scene, name, number):
    """No error, since a later version may know them (test_interface.py has the note): the default's picture."""
    add_plane(lit_scene, size=20)
    expected = render_pixels(lit_scene)["Combined"]
    get = getattr(lit_scene.penumbra, "bl_system_properties_get", None)  # Blender 5.0+
    (get(do_create=True) if get else lit_scene.penumbra)[name] = number
    assert (render_pixels(lit_scene)["Combined"] == expected).all()


def png(width, height, body=b""):
    """A PNG file of that header, 8-bit RGB, whatever follows it."""

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))
    return b"\x89PNG\r\n\x1a\n" + header + chunk(b"IDAT", body) + chunk(b"IEND", b"")


BAD_IMAGES = {
    "missing": None,
    "empty": b"",
    "no image": b"#!/bin/sh\nexit 1\n" * 100,
    "truncated": png(64, 64, zlib.compress(b"\0" * 64 * 193))[:60],
    "corrupt": png(64, 64, b"\x78\x9c" + bytes(range(256))),
    "huge": png(40_000, 40_000, zlib.compress(b"\0" * 1000)),
    "larger than memory": png(2**31 - 1, 2**31 - 1, b""),
}


@pytest.mark.parametrize("kind", BAD_IMAGES)
def test_d48_bad_textures(lit_scene, tmp_path, kind):
    """An error that names the material or its image, or a finite picture and a note that does; Blender lives."""
    path = tmp_path / "Bad.png"
    if BAD_IMAGES[kind] is not None:
        path.write_bytes(BAD_IMAGES[kind])
    image = bpy.data.images.new("Bad.png", 4, 4)
    image.source, image.filepath = "FILE", str(path)
    material = bpy.data.materials.new("Painted")
    material.use_nodes = True
    texture = material.node_tree.nodes.new("ShaderNodeTexImage")
    texture.image = image
    principled = material.node_tree.nodes["Principled BSDF"]
    material.node_tree.links.new(texture.outputs["Color"], principled.inputs["Base Color"])
    add_plane(lit_scene, size=20).data.materials.append(material)
    try:
        assert np.isfinite(render_pixels(lit_scene)["Combined"]).all()
        told = " ".join(statistics.last_render["warnings"])
    except RuntimeError as error:
        told = str(error)
    assert "Painted" in told or "Bad.png" in told
