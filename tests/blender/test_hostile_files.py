# SPDX-License-Identifier: GPL-3.0-or-later
"""The rows of the catalogue of hard cases in which Blender has a say (the others: tests/hard_cases): what a hostile or
broken file may hold. Lights, worlds and settings that are no numbers, tangled node trees, corrupt images."""

import struct
import zlib

import bpy
import numpy as np
import pytest
from helpers import add_camera, add_cube, add_light, add_plane, emissive_material, fails, render_pixels, set_raw
from penumbra import statistics

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
