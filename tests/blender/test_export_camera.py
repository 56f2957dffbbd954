# SPDX-License-Identifier: GPL-3.0-or-later
"""The camera and the picture's frame: every pixel sees the point that Cycles' pixel sees.

Oracle: Cycles' Position pass over an endless-looking plane; its ray is within 0.005 pixels of the pixel's centre. And
Blender's own projection of known points.
"""

import math

import numpy as np
import pytest
from bpy_extras.object_utils import world_to_camera_view
from helpers import add_camera, add_plane, render_pixels, use_cycles_as_reference
from mathutils import Vector

VARIANTS = {
    "perspective": {},
    "tele": {"lens": 200.0},
    "wide": {"lens": 12.0},
    "shift": {"shift_x": 0.3, "shift_y": -0.2},
    "fit vertical": {"sensor_fit": "VERTICAL", "sensor_height": 20.0},
    "fit horizontal": {"sensor_fit": "HORIZONTAL", "sensor_width": 30.0},
    "fit horizontal, portrait": {"sensor_fit": "HORIZONTAL", "resolution_x": 40, "resolution_y": 64},
    "portrait": {"resolution_x": 40, "resolution_y": 64, "shift_x": 0.1, "shift_y": 0.2},
    "pixel aspect x": {"pixel_aspect_x": 2.0},
    "pixel aspect y, shift": {"pixel_aspect_y": 1.5, "shift_y": 0.25},
    "percentage": {"resolution_percentage": 53, "resolution_x": 101, "resolution_y": 77},
    "orthographic": {"type": "ORTHO", "ortho_scale": 7.0},
    "orthographic, shift, portrait": {"type": "ORTHO", "ortho_scale": 5.0, "shift_x": 0.4, "shift_y": 0.1,
                                      "resolution_x": 40, "resolution_y": 64, "pixel_aspect_x": 1.5},
}  # fmt: skip
BORDERS = [(0.0, 1.0, 0.0, 1.0), (0.21, 0.74, 0.13, 0.62), (0.5, 0.51, 0.5, 0.53), (0.333333, 0.666667, 0.1, 0.9)]


def set_up(scene, scale=(1, 1, 1), **settings):
    """A tilted view of a large plane; settings are the camera's or the render's."""
    plane = add_plane(scene, size=1000)
    camera = add_camera(scene, location=(1, -2, 10), rotation=(0.35, 0.1, 0.6))
    camera.scale = scale
    for name, value in settings.items():
        setattr(camera.data if hasattr(camera.data, name) else scene.render, name, value)
    return plane, camera


def assert_same_positions(scene):
    """Penumbra's Position and Depth passes against Cycles'; positions in units of the pixel's size on the plane."""
    ours = render_pixels(scene)
    use_cycles_as_reference(scene, samples=1)
    cycles = render_pixels(scene, "CYCLES")
    assert ours["Position"].shape == cycles["Position"].shape
    seen = cycles["Depth"][..., 0] < 1e9
    assert np.array_equal(ours["Depth"][..., 0] < 1e9, seen) and seen.any()
    error = np.linalg.norm(ours["Position"] - cycles["Position"], axis=2)[seen]
    steps = np.linalg.norm(np.diff(ours["Position"], axis=1), axis=2)[seen[:, 1:] & seen[:, :-1]]
    pixel = np.median(steps) if steps.size else 0.05  # the size in the whole picture of the border test
    assert np.percentile(error / pixel, 99) < 0.05
    np.testing.assert_allclose(ours["Depth"][seen], cycles["Depth"][seen], rtol=1e-3)
    return ours


@pytest.mark.parametrize("settings", VARIANTS.values(), ids=VARIANTS.keys())
def test_every_pixel_sees_what_cycles_sees(scene, settings):
    set_up(scene, **settings)
    assert_same_positions(scene)


@pytest.mark.parametrize("scale", [(3, 3, 3), (1, 2, 0.5), (-1, 1, 1)])
def test_scaled_cameras(scene, scale):
    set_up(scene, scale=scale)
    assert_same_positions(scene)


def test_points_project_where_blender_says(scene):
    _, camera = set_up(scene, shift_x=0.1, lens=35.0)
    positions = render_pixels(scene)["Position"]
    height, width, _ = positions.shape
    for y, x in [(0, 0), (7, 50), (24, 32), (height - 1, width - 1)]:
        u, v, _ = world_to_camera_view(scene, camera, Vector(positions[y, x].tolist()))
        assert (u * width, v * height) == pytest.approx((x + 0.5, y + 0.5), abs=0.01)


@pytest.mark.parametrize("crop", [False, True])
@pytest.mark.parametrize("border", BORDERS)
def test_border_is_cut_out_of_the_whole_picture(scene, border, crop):
    set_up(scene, resolution_x=101, resolution_y=67)
    whole = render_pixels(scene)
    render = scene.render
    render.use_border, render.use_crop_to_border = True, crop
    render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = border
    part = assert_same_positions(scene)
    left, right = (int(np.float32(b) * np.float32(101)) for b in border[:2])
    bottom, top = (int(np.float32(b) * np.float32(67)) for b in border[2:])
    for name, pixels in part.items():
        expected = whole[name][bottom:top, left:right]
        if crop:
            assert np.array_equal(pixels, expected), name
        else:
            assert pixels.shape == whole[name].shape
            assert np.array_equal(pixels[bottom:top, left:right], expected), name
            outside = np.ones(pixels.shape[:2], bool)
            outside[bottom:top, left:right] = False
            assert np.all(pixels[outside] >= 1e10 if name == "Depth" else pixels[outside] == 0), name  # Blender's own


def test_clip_start_and_end(scene):
    set_up(scene, clip_start=9.0, clip_end=10.5)
    depth = assert_same_positions(scene)["Depth"]
    assert 0.05 < (depth < 1e9).mean() < 0.95


def test_camera_marker_chosen_by_the_frame(scene):
    set_up(scene)
    first, second = scene.camera, add_camera(scene, "Second", location=(0, 0, 5))
    for frame, camera in ((1, first), (10, second)):
        scene.timeline_markers.new(camera.name, frame=frame).camera = camera
    scene.frame_set(10)
    assert scene.camera == second
    depth = render_pixels(scene)["Depth"]
    np.testing.assert_allclose(depth, 5.0, rtol=1e-5)


def test_orthographic_window_is_its_scale(scene):
    add_plane(scene, size=1000)
    add_camera(scene, location=(0, 0, 10), type="ORTHO", ortho_scale=8.0)
    x = render_pixels(scene)["Position"][..., 0]
    np.testing.assert_allclose(x, np.broadcast_to((np.arange(64) + 0.5) / 64 * 8.0 - 4.0, x.shape), atol=1e-5)


def test_perspective_field_of_view(scene):
    add_plane(scene, size=1000)
    add_camera(scene, location=(0, 0, 10), angle=math.radians(60))
    x = render_pixels(scene)["Position"][..., 0]
    edge = 10 * math.tan(math.radians(30))
    np.testing.assert_allclose(x[:, -1], edge * 63 / 64, rtol=1e-5)
