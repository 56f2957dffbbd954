# SPDX-License-Identifier: GPL-3.0-or-later
"""Image textures against Cycles, pixel by pixel through an Emission shader (see test_against_cycles_nodes.py), and what
becomes of images that cannot be read. Tolerance 1e-4: Cycles' rays go through a filter of 0.01 pixels."""

import bpy
import numpy as np
import OpenImageIO as oiio
import pytest
from cycles_reference import colour, render_with_penumbra
from material_scenes import Tree, assert_values_equal, show
from penumbra import compat, statistics


def write(path, channels: int = 3, kind=oiio.UINT8, size=(8, 16), seed: int = 1, scale: float = 1.0):
    """Random pixels in a file; its path."""
    pixels = scale * np.random.default_rng(seed).random((*size, channels)).astype(np.float32)
    image = oiio.ImageBuf(oiio.ImageSpec(size[1], size[0], channels, kind))
    image.set_pixels(image.roi, pixels)
    assert image.write(str(path), kind)
    return path


def texture(t, image, output="Color", scale=1.3, **properties):
    vector = t.add(
        "ShaderNodeMapping", {"Vector": t.coordinates("UV"), "Scale": (scale,) * 3, "Location": (0.13, 0.27, 0)}
    )
    return t.add("ShaderNodeTexImage", {"Vector": vector.outputs[0]}, image=image, **properties).outputs[output]


def check(scene, build) -> None:
    tree = Tree()
    show(scene, tree.emit(build(tree)))
    assert_values_equal(scene, 1e-4)


@pytest.mark.parametrize("extension", ["REPEAT", "EXTEND", "CLIP"])
@pytest.mark.parametrize("interpolation", ["Linear", "Closest", "Cubic", "Smart"])
def test_wrap_and_interpolation(scene, tmp_path, extension, interpolation):
    image = bpy.data.images.load(str(write(tmp_path / "a.png")))
    check(scene, lambda t: texture(t, image, extension=extension, interpolation=interpolation))


@pytest.mark.parametrize("space", ["sRGB", "Non-Color"])
@pytest.mark.parametrize(
    ("name", "channels", "kind"),
    [("a.png", 3, oiio.UINT8), ("a.png", 1, oiio.UINT8), ("a.jpg", 3, oiio.UINT8), ("a.tif", 3, oiio.UINT8)],
)
def test_formats_and_colour_spaces(scene, tmp_path, name, channels, kind, space):
    image = bpy.data.images.load(str(write(tmp_path / name, channels, kind)))
    image.colorspace_settings.name = space
    check(scene, lambda t: texture(t, image))


def test_float_images_keep_what_is_above_white(scene, tmp_path):
    image = bpy.data.images.load(str(write(tmp_path / "a.exr", 3, oiio.HALF, scale=5.0)))
    check(scene, lambda t: texture(t, image))


@pytest.mark.parametrize("alpha_is_used", [False, True])
@pytest.mark.parametrize("mode", ["STRAIGHT", "PREMUL", "CHANNEL_PACKED", "NONE"])
def test_alpha(scene, tmp_path, mode, alpha_is_used):
    image = bpy.data.images.load(str(write(tmp_path / "a.png", 4)))
    image.alpha_mode = mode

    def build(t):
        value = texture(t, image)
        if not alpha_is_used:
            return value
        return t.add("ShaderNodeVectorMath", {0: value, 1: value.node.outputs["Alpha"]}, operation="ADD").outputs[0]

    if mode == "PREMUL" and compat.PREMULTIPLIED_IS_DIVIDED:  # what Cycles makes of it is told, not rendered
        tree = Tree()
        show(scene, tree.emit(build(tree)))
        render_with_penumbra(scene, 16)
        assert any("premultiplied alpha" in note for note in statistics.last_render["warnings"])
        return
    check(scene, build)


def test_packed(scene, tmp_path):
    path = write(tmp_path / "a.png", 4)
    image = bpy.data.images.load(str(path))
    image.pack()
    path.unlink()
    check(scene, lambda t: texture(t, image))


@pytest.mark.parametrize("is_float", [False, True])
def test_generated(scene, is_float):
    image = bpy.data.images.new("Grid", 32, 32, float_buffer=is_float)
    image.generated_type = "COLOR_GRID"
    check(scene, lambda t: texture(t, image))


def test_painted_and_not_saved(scene):
    image = bpy.data.images.new("Painted", 8, 8)
    pixels = np.random.default_rng(3).random((8, 8, 4)).astype(np.float32)
    pixels[..., 3] = 1
    image.pixels.foreach_set(pixels.ravel())
    image.update()
    check(scene, lambda t: texture(t, image))


def test_udim(scene, tmp_path):
    for number in (1001, 1002, 1011):
        write(tmp_path / f"tile.{number}.png", seed=number)
    image = bpy.data.images.load(str(tmp_path / "tile.1001.png"))
    image.source = "TILED"
    image.filepath = str(tmp_path / "tile.<UDIM>.png")
    for number in (1002, 1011):
        image.tiles.new(number)
    check(scene, lambda t: t.add("ShaderNodeTexImage", {"Vector": t.add("ShaderNodeMapping", {
        "Vector": t.coordinates("UV"), "Scale": (2, 2, 2)}).outputs[0]}, image=image).outputs[0])  # fmt: skip


@pytest.mark.parametrize("frame", [1, 2, 7])
def test_sequence(scene, tmp_path, frame):
    for number in (1, 2, 3):
        write(tmp_path / f"a_{number:03}.png", seed=number)
    image = bpy.data.images.load(str(tmp_path / "a_001.png"))
    image.source = "SEQUENCE"
    scene.frame_set(frame)

    def build(t):
        value = texture(t, image)
        value.node.image_user.frame_duration = 3
        return value

    check(scene, build)


def magenta_and_notes(scene, image):
    tree = Tree("Wall")
    show(scene, tree.emit(texture(tree, image)))
    picture = colour(render_with_penumbra(scene, 16))
    assert (picture[5, 24] == (1, 0, 1)).all()
    return statistics.last_render["warnings"]


@pytest.mark.parametrize("content", [None, b"", b"no picture", b"\x89PNG\r\n\x1a\n" + bytes(64)])
def test_a_file_that_cannot_be_read_is_magenta_and_named(scene, tmp_path, content):
    path = write(tmp_path / "a.png")
    image = bpy.data.images.load(str(path))
    path.unlink()
    if content is not None:
        path.write_bytes(content)
    (note,) = magenta_and_notes(scene, image)
    assert note.startswith("material 'Wall': node 'Image Texture': image 'a.png': ")
    assert note.endswith("; rendered in magenta")


def test_a_damaged_file_ends_in_a_note(scene, tmp_path):
    """The header is whole, the pixels are not."""
    path = write(tmp_path / "a.png", size=(512, 512))
    image = bpy.data.images.load(str(path))
    path.write_bytes(path.read_bytes()[:20000])
    tree = Tree("Wall")
    show(scene, tree.emit(texture(tree, image)))
    assert np.isfinite(colour(render_with_penumbra(scene, 16))).all()
    assert all("image 'a.png'" in note for note in statistics.last_render["warnings"])


def test_a_header_that_promises_too_much_is_refused(scene, tmp_path):
    """A PPM of 100,000 x 100,000 pixels, in 20 bytes."""
    path = tmp_path / "bomb.ppm"
    path.write_bytes(b"P6 100000 100000 255\n" + bytes(16))
    image = bpy.data.images.new("Bomb", 4, 4)
    image.source, image.filepath = "FILE", str(path)
    (note,) = magenta_and_notes(scene, image)
    assert "100000 x 100000" in note or "100000x100000" in note  # OpenImageIO refuses it itself since 2.5


def test_a_movie_is_named(scene, tmp_path):
    image = bpy.data.images.load(str(write(tmp_path / "a.png")))
    image.source = "MOVIE"
    assert magenta_and_notes(scene, image) == [
        "material 'Wall': image 'a.png': the source 'MOVIE' is not supported yet; rendered in magenta"
    ]
