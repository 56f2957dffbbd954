# SPDX-License-Identifier: GPL-3.0-or-later
"""The world as background and as light: colour and environment texture, against Cycles in the same Blender."""

import bpy
import numpy as np
import pytest
from cycles_reference import colour, converge_cycles, relative_rmse, render_with_cycles, render_with_penumbra
from helpers import add_camera, add_cube, add_plane, make_lambertian, read_exr, render_pixels
from penumbra import compat, native
from penumbra.export import Kept, world
from recording import record


def set_world(scene, color=(0.5, 0.5, 0.5), strength=1.0):
    """A world of one Background node, which is returned."""
    scene.world = bpy.data.worlds.new("Sky")
    scene.world.use_nodes = True
    background = scene.world.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = (*color, 1)
    background.inputs["Strength"].default_value = strength
    return background


def sky_picture(width=64, height=32, sun=30.0) -> np.ndarray:
    """(height, width, 3): a gradient of changing hue with one bright spot."""
    y, x = np.mgrid[0:height, 0:width]
    sky = np.stack([0.2 + 0.5 * x / width, 0.3 + 0.4 * y / height, 0.6 - 0.3 * x / width], axis=-1)
    sky[height * 3 // 4 : height * 3 // 4 + 2, width // 3 : width // 3 + 2] = sun
    return sky.astype(np.float32)


def set_environment(scene, pixels, **mapping):
    """A world of an environment texture; `mapping`: vector_type and rotation of a Mapping node."""
    background = set_world(scene)
    height, width = pixels.shape[:2]
    image = bpy.data.images.new("Picture", width, height, float_buffer=True)
    image.pixels.foreach_set(np.dstack([pixels, np.ones((height, width), np.float32)]).ravel())
    image.update()
    image.pack()
    tree = scene.world.node_tree
    texture = tree.nodes.new("ShaderNodeTexEnvironment")
    texture.image = image
    tree.links.new(texture.outputs[0], background.inputs["Color"])
    if mapping:
        node = tree.nodes.new("ShaderNodeMapping")
        node.vector_type = mapping["vector_type"]
        node.inputs["Rotation"].default_value = mapping["rotation"]
        coordinates = tree.nodes.new("ShaderNodeTexCoord")
        tree.links.new(coordinates.outputs["Generated"], node.inputs["Vector"])
        tree.links.new(node.outputs[0], texture.inputs["Vector"])
    return texture


def add_box_on_a_floor(scene) -> None:
    add_plane(scene, "Floor", size=10.0)
    add_cube(scene, size=1.0, location=(0, 0, 0.5))
    add_camera(scene, location=(0, 0, 8), type="ORTHO", ortho_scale=6.0)


def test_colour_lights_as_in_cycles(scene):
    """Tolerance 1 % (relative RMSE), Cycles' noise below half of that."""
    add_box_on_a_floor(scene)
    set_world(scene, (0.4, 0.5, 0.7), 2.0)
    cycles, noise = converge_cycles(scene, samples=1024)
    ours, expected = colour(render_with_penumbra(scene)), colour(cycles)
    assert expected.min() < 0.8 * expected.max()
    assert relative_rmse(noise, expected) < 5e-3
    assert relative_rmse(ours - expected, expected) < 1e-2


MAPPINGS = {
    "unmapped": {},
    "turned": {"vector_type": "POINT", "rotation": (0.3, -0.5, 1.1)},
    "turned as texture": {"vector_type": "TEXTURE", "rotation": (0.3, -0.5, 1.1)},
    "turned as vector": {"vector_type": "VECTOR", "rotation": (0.0, 0.0, 2.0)},
}


@pytest.mark.parametrize("mapping", MAPPINGS.values(), ids=MAPPINGS)
def test_environment_lights_as_in_cycles(scene, mapping):
    """Pixels of 5.6 degrees: constant here, interpolated in Cycles, which moves a shadow's edge a little. Tolerance 1 %
    in the mean and 4 % (relative RMSE), Cycles' noise below a third of that."""
    add_box_on_a_floor(scene)
    set_environment(scene, sky_picture(), **mapping)
    cycles, noise = converge_cycles(scene, samples=1024)
    ours, expected = colour(render_with_penumbra(scene)), colour(cycles)
    assert relative_rmse(noise, expected) < 1.3e-2
    np.testing.assert_allclose(ours.mean((0, 1)), expected.mean((0, 1)), rtol=1e-2)
    assert relative_rmse(ours - expected, expected) < 4e-2


@pytest.mark.parametrize("mapping", MAPPINGS.values(), ids=MAPPINGS)
@pytest.mark.parametrize("interpolation", ["Linear", "Closest"])
def test_environment_is_seen_as_in_cycles(scene, mapping, interpolation):
    """A wide view of nothing else; 1e-3 of the brightest, rounding of directions, but for a few pixels beside the
    bright spot (0.5 %); with Closest but for pixels whose ray meets an edge (2 %)."""
    set_environment(scene, sky_picture(sun=2.0), **mapping).interpolation = interpolation
    add_camera(scene, rotation=(1.4, 0.2, 0.7), lens=12)
    ours, cycles = (colour(passes) for passes in (render_with_penumbra(scene), render_with_cycles(scene, 4)))
    far = abs(ours - cycles).max(-1) > 2e-3
    assert np.ptp(cycles) > 0.3
    assert far.mean() <= (0.02 if interpolation == "Closest" else 0.005)


def test_a_byte_picture_is_decoded(scene, monkeypatch):
    """The sRGB curve: 0.5 is 0.2140 in the scene; bytes round to 1 / 255."""
    add_camera(scene)
    texture = set_environment(scene, sky_picture())
    texture.image = bpy.data.images.new("Bytes", 4, 2)
    texture.image.pixels.foreach_set(np.tile(np.float32([0.5, 0.5, 0.0, 1.0]), 8))
    found = record(scene, monkeypatch)
    np.testing.assert_allclose(
        found.background.image.pixels, np.broadcast_to([0.2140, 0.2140, 0.0], (2, 4, 3)), atol=4e-3
    )
    assert found.notes == []


def test_black_world_costs_nothing(scene, monkeypatch):
    add_box_on_a_floor(scene)
    set_world(scene, strength=0.0)
    found = record(scene, monkeypatch)
    assert not found.pixels["Combined"][..., :3].any() and not found.pixels["Light Samples"].any()


@pytest.mark.parametrize("off", [("diffuse", "glossy"), ("camera",), ("camera", "diffuse", "glossy")], ids=str)
def test_ray_visibility_is_that_of_cycles(scene, off):
    """Tolerance 2 % of the sky, which fills most of the frame; Cycles' noise below half of that."""
    add_box_on_a_floor(scene)
    scene.camera.data.ortho_scale = 20.0
    set_world(scene)
    for name in off:
        setattr(scene.world.cycles_visibility, name, False)
    cycles, noise = converge_cycles(scene, samples=128)
    ours, expected = colour(render_with_penumbra(scene)), colour(cycles)
    np.testing.assert_array_equal(ours[0, 0] == 0, "camera" in off)
    np.testing.assert_array_equal(ours[20, 24] == 0, "diffuse" in off)
    assert relative_rmse(noise, np.full(3, 0.5)) < 1e-2
    assert relative_rmse(ours - expected, np.full(3, 0.5)) < 2e-2


def test_ray_visibility_of_one_kind_is_noted(scene, monkeypatch):
    add_box_on_a_floor(scene)
    set_world(scene)
    scene.world.cycles_visibility.diffuse = False
    assert "ray visibility of diffuse and glossy" in record(scene, monkeypatch).notes[0]


def test_what_is_left_out_is_named(scene, monkeypatch):
    add_camera(scene)
    texture = set_environment(scene, sky_picture())
    texture.projection = "MIRROR_BALL"
    assert "projection of node 'Environment Texture' is not supported yet" in record(scene, monkeypatch).notes[0]
    texture.projection = "EQUIRECTANGULAR"
    texture.image = bpy.data.images.new("Gone", 1, 1)
    texture.image.source, texture.image.filepath = "FILE", "//no_such_file.hdr"
    found = record(scene, monkeypatch)
    assert found.notes == ["world 'Sky': image 'Gone' can't be read from '//no_such_file.hdr'; rendered magenta"]
    np.testing.assert_allclose(found.pixels["Combined"][0, 0], (1, 0, 1, 1))
    tree = scene.world.node_tree
    tree.links.new(tree.nodes.new("ShaderNodeAddShader").outputs[0], tree.nodes["World Output"].inputs["Surface"])
    assert "node 'Add Shader' is not supported yet" in record(scene, monkeypatch).notes[0]


def test_a_picture_is_read_again_only_if_it_has_changed(scene, tmp_path):
    """Colour space, painting, saving and reloading are seen; what no export uses any more is let go of."""
    pn, kept = native.require(), Kept(native.require())
    source = set_environment(scene, sky_picture(8, 4)).image
    source.filepath_raw, source.file_format = str(tmp_path / "sky.exr"), "OPEN_EXR"
    source.save()
    image = bpy.data.images.load(str(tmp_path / "sky.exr"))

    def read(image=image):
        kept.begin()
        picture = world.picture_of(pn, image, [], kept) if image else None
        kept.end()
        return picture

    first = read()
    np.testing.assert_allclose(first.pixels, sky_picture(8, 4), rtol=1e-3)
    assert read() is first and kept.skies_read == 1
    linear, image.colorspace_settings.name = image.colorspace_settings.name, "sRGB"
    assert not np.array_equal(read().pixels, first.pixels)
    image.colorspace_settings.name = linear
    painted = np.array(image.pixels[:], dtype=np.float32).reshape(4, 8, 4) * 2
    image.pixels.foreach_set(painted.ravel())
    image.update()
    before = kept.skies_read
    for _ in range(2):  # nothing tells whether it was painted on, so it is read each time
        np.testing.assert_array_equal(read().pixels, painted[..., :3])
    assert kept.skies_read == before + 2
    image.save()
    saved = read()
    np.testing.assert_allclose(saved.pixels, painted[..., :3], rtol=1e-3)
    assert read() is saved
    read(None)
    assert read() is not saved


def test_a_kept_picture_shows_what_a_new_one_does(scene, tmp_path):
    """Two frames of an animation with persistent data, the second with the first one's picture, as if rendered
    alone; kept meshes are traced in a space of their own (README)."""
    add_box_on_a_floor(scene)
    make_lambertian(scene)
    set_environment(scene, sky_picture())
    scene.render.use_persistent_data, scene.frame_start, scene.frame_end = True, 1, 2
    compat.set_file_format(scene.render.image_settings, "OPEN_EXR")
    scene.render.image_settings.color_depth = "32"
    scene.render.filepath = str(tmp_path / "frame_")
    bpy.ops.render.render(animation=True)
    second = read_exr(tmp_path / "frame_0002.exr")["Combined"]
    scene.render.use_persistent_data = False
    alone = render_pixels(scene)["Combined"]
    assert alone.max() > 0.1
    np.testing.assert_allclose(second[..., :3], alone[..., :3], rtol=1e-4, atol=1e-4)
