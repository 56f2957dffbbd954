# SPDX-License-Identifier: GPL-3.0-or-later
"""Cameras against Cycles: Position, Normal and Depth of three boxes on a floor, one ray through each pixel's centre.

Tolerances: 1e-4 m (seen: 3e-5 m, from Cycles' single precision) in pictures of 0.01-0.1 m to the pixel, so a hundredth
of a pixel or less; 1e-6 for normals (seen: 1e-7). Pixels beside an edge are left out of that, but no more than two of
them in a picture may differ by more.
"""

import math

import numpy as np
import pytest
from cycles_reference import away_from_edges, object_index, render_with_cycles, render_with_penumbra
from helpers import add_camera, add_cube, add_plane

METRES = 1e-4
SENSOR = {"sensor_width": 30.0, "sensor_height": 20.0, "ortho_scale": 7.0, "shift_x": 0.1, "shift_y": 0.07}


@pytest.fixture
def boxes(scene):
    """Three turned boxes on a floor, all faces flat, seen obliquely by a camera that is rolled a little."""
    add_plane(scene, "Floor", size=12.0)
    add_cube(scene, "A", size=1.2, location=(-1.5, 0.7, 0.6), rotation=(0, 0, 0.5))
    add_cube(scene, "B", size=1.0, location=(1.2, -0.3, 1.1), rotation=(0.4, 0.7, 0.2))
    add_cube(scene, "C", size=0.8, location=(0.2, 2.1, 0.4), rotation=(0, 0, 1.1), scale=(1, 2, 0.7))
    add_camera(scene, location=(1.5, -6.5, 4.2), rotation=(1.05, 0.06, 0.21))
    return scene


def assert_passes_equal(scene, size: tuple[int, int]) -> None:
    """Position, Normal and Depth of both engines, `size` (width, height) pixels: objects and background."""
    ours, cycles = render_with_penumbra(scene, light_samples=1), render_with_cycles(scene, samples=1)
    inside, background = away_from_edges(cycles, crease_cosine=0.999), object_index(cycles) == 0
    assert inside.sum() > 100
    for name, tolerance in {"Position": METRES, "Normal": 1e-6, "Depth": METRES}.items():
        assert ours[name].shape == cycles[name].shape == (size[1], size[0], cycles[name].shape[2]), name
        np.testing.assert_allclose(ours[name][inside], cycles[name][inside], rtol=0, atol=tolerance, err_msg=name)
        differs = np.abs(ours[name] - cycles[name]).max(-1) > tolerance
        assert differs.sum() <= 2, f"{name}: {differs.sum()} pixels differ"
        np.testing.assert_array_equal(ours[name][background & ~differs], cycles[name][background & ~differs], name)


CAMERAS = {
    "perspective": {},
    "wide": {"lens": 18.0},
    "tele": {"lens": 200.0},
    "field of view": {"lens_unit": "FOV", "angle": 1.9},
    "shifted": {"shift_x": 0.21, "shift_y": -0.13},
    "orthographic": {"type": "ORTHO", "ortho_scale": 7.0},
    "orthographic, shifted": {"type": "ORTHO", "ortho_scale": 7.0, "shift_x": 0.21, "shift_y": -0.13},
    "near clipping": {"clip_start": 6.0},
    "far clipping": {"clip_end": 8.0},
    "orthographic, clipped": {"type": "ORTHO", "ortho_scale": 7.0, "clip_start": 6.0, "clip_end": 8.0},
}


@pytest.mark.parametrize("settings", CAMERAS.values(), ids=CAMERAS)
def test_camera(boxes, settings):
    for name, value in settings.items():
        setattr(boxes.camera.data, name, value)
    assert_passes_equal(boxes, (64, 48))


@pytest.mark.parametrize("scale", [(2, 2, 2), (0.5, 3, 1), (-1, 1, 1), (1, -1, 1)], ids=str)
def test_scale_of_the_camera_object_does_not_count_but_its_sign_does(boxes, scale):
    boxes.camera.scale = scale
    assert_passes_equal(boxes, (64, 48))


@pytest.mark.parametrize("aspect", [(1, 1), (2, 1), (1, 1.7)], ids=str)
@pytest.mark.parametrize("size", [(64, 48), (48, 64)], ids=str)
@pytest.mark.parametrize("fit", ["AUTO", "HORIZONTAL", "VERTICAL"])
@pytest.mark.parametrize("kind", ["PERSP", "ORTHO"])
def test_sensor_fit_and_pixel_aspect(boxes, kind, fit, size, aspect):
    """A 3:2 sensor, shifted; the frame is wider or narrower than it."""
    for name, value in SENSOR.items():
        setattr(boxes.camera.data, name, value)
    boxes.camera.data.type, boxes.camera.data.sensor_fit = kind, fit
    boxes.render.resolution_x, boxes.render.resolution_y = size
    boxes.render.pixel_aspect_x, boxes.render.pixel_aspect_y = aspect
    assert_passes_equal(boxes, size)


@pytest.mark.parametrize(("percentage", "size"), [(50, (32, 24)), (37, (23, 17)), (133, (85, 63)), (200, (128, 96))])
def test_resolution_percentage(boxes, percentage, size):
    boxes.render.resolution_percentage = percentage
    assert_passes_equal(boxes, size)


BORDERS = {
    (0.2, 0.7, 0.1, 0.6): (32, 24),
    (0.333, 0.777, 0.123, 0.456): (28, 16),
    (0.0, 0.5, 0.5, 1.0): (32, 24),
    (0.9, 1.0, 0.0, 1.0): (7, 48),
}
"""(left, right, bottom, top) -> pixels of a 64 x 48 frame."""


@pytest.mark.parametrize("crop", [False, True], ids=["padded", "cropped"])
@pytest.mark.parametrize("border", BORDERS, ids=str)
def test_border(boxes, border, crop):
    """Without cropping Blender fills the rest of the frame with zeros."""
    render = boxes.render
    render.use_border, render.use_crop_to_border = True, crop
    render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = border
    assert_passes_equal(boxes, BORDERS[border] if crop else (64, 48))


def test_border_percentage_aspect_and_shift_together(boxes):
    render = boxes.render
    render.use_border = render.use_crop_to_border = True
    render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = 0.21, 0.83, 0.17, 0.91
    render.resolution_percentage, render.pixel_aspect_x, boxes.camera.data.shift_x = 163, 1.5, 0.1
    assert_passes_equal(boxes, (86 - 21, 70 - 13))  # of 104 x 78 pixels


@pytest.mark.parametrize("transparent", [False, True], ids=["opaque", "transparent"])
def test_alpha_of_the_background(boxes, transparent):
    """Cycles' alpha of an edge pixel is 0 or 1 here, too: its one ray goes through the pixel's centre."""
    boxes.camera.data.lens = 18.0
    boxes.camera.rotation_euler = (math.radians(80), 0, 0)
    boxes.render.film_transparent = transparent
    ours, cycles = (render(boxes, 1)["Combined"][..., 3] for render in (render_with_penumbra, render_with_cycles))
    assert (cycles == 1).all() != transparent
    np.testing.assert_array_equal(ours, cycles)
