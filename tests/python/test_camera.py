# SPDX-License-Identifier: GPL-3.0-or-later
"""Primary rays against positions computed by hand: cameras, clip range, background, filter, data passes.

Position and Depth are float32 of a hit in double on a triangle whose vertices were rounded to float32 in a space
where the scene spans about -1 ... 1: 2^-22 of the scene's size, times the slope at which the ray meets the surface.
"""

import numpy as np
import penumbra_native as pn
import pytest
from scenes import add, box, floor, light_above, look_down, parallelogram, render, rotation, scaling, translation

NO_DEPTH = 1e10
WIDTH, HEIGHT = 13, 9
WINDOWS = {"centred": (-0.4, 0.4, -0.3, 0.3), "shifted": (-0.1, 0.7, 0.05, 0.65), "mirrored": (0.4, -0.4, -0.3, 0.3)}
VIEW = translation(0.5, -3, 2.5) @ rotation([0, 0, 1], 12) @ rotation([1, 0, 0], 40)


def with_floor(kind, window, clip=(0.01, 100.0), matrix=VIEW):
    scene = pn.Scene()
    add(scene, "floor", floor(half=20))
    scene.add_area_light("key", "RECTANGLE", light_above(), (1, 1), (3, 3, 3))
    scene.set_camera(kind, matrix, window, clip)
    return scene


def expected_hits(kind, window):
    """Position and depth (along the view axis) of the floor z = 0 at each pixel's centre."""
    left, right, bottom, top = window
    u, v = np.meshgrid(
        left + (np.arange(WIDTH) + 0.5) / WIDTH * (right - left),
        bottom + (np.arange(HEIGHT) + 0.5) / HEIGHT * (top - bottom),
    )
    zero, one = np.zeros_like(u), np.ones_like(u)
    perspective = kind == "PERSPECTIVE"
    origin = np.stack([zero, zero, zero] if perspective else [u, v, zero], axis=-1) @ VIEW[:3, :3].T + VIEW[:3, 3]
    direction = np.stack([u, v, -one] if perspective else [zero, zero, -one], axis=-1) @ VIEW[:3, :3].T
    depth = -origin[..., 2] / direction[..., 2]  # direction has length 1 along the view axis
    return origin + depth[..., None] * direction, depth


@pytest.mark.parametrize("window", WINDOWS)
@pytest.mark.parametrize("kind", ["PERSPECTIVE", "ORTHOGRAPHIC"])
def test_rays_go_through_pixel_centres(kind, window):
    """The floor is 40 m wide, so that its rounding is 40 x 2^-23 = 5e-6 m; the rays meet it at 30 degrees or more:
    1e-5."""
    picture = render(with_floor(kind, WINDOWS[window]), WIDTH, HEIGHT, stop_rule="FIXED", light_samples=1)
    position, depth = expected_hits(kind, WINDOWS[window])
    np.testing.assert_allclose(picture.position, position, atol=1e-5)
    np.testing.assert_allclose(picture.passes["Depth"][..., 0], depth, atol=1e-5)
    np.testing.assert_allclose(picture.passes["Normal"], np.broadcast_to([0, 0, 1], position.shape), atol=1e-6)
    assert (picture.passes["Combined"][..., 3] == 1).all()


def test_row_zero_is_the_bottom_row():
    """A step on the upper half of the picture, seen from above: nearer there."""
    scene = with_floor("ORTHOGRAPHIC", (-1, 1, -1, 1), matrix=translation(0, 0, 5))
    add(scene, "step", box([-1, 0, 0], [1, 1, 0.5]))
    depth = render(scene, 4, stop_rule="FIXED", light_samples=1).passes["Depth"][..., 0]
    np.testing.assert_allclose(depth, np.repeat([5, 5, 4.5, 4.5], 4).reshape(4, 4), atol=1e-5)


@pytest.mark.parametrize("kind", ["PERSPECTIVE", "ORTHOGRAPHIC"])
def test_clip_range_is_along_the_view_axis(kind):
    """Plates at depths 1, 2 and 3: the clip start takes the first away, the clip end the last, at every pixel
    alike."""

    def depths(start, end):
        scene = pn.Scene()
        for z in (4, 3, 2):
            add(scene, f"plate {z}", floor(half=30, z=z))
        scene.set_camera(kind, translation(0, 0, 5), (-1, 1, -1, 1), (start, end))
        return np.unique(np.round(render(scene, 7).passes["Depth"], 4))

    assert depths(0.1, 10) == [1]
    assert depths(1.01, 10) == [2]
    assert depths(2.01, 2.99) == [NO_DEPTH]
    assert depths(2.5, 3.01) == [3]


@pytest.mark.parametrize("distance", [1e3, 1e6, 1e8])
def test_a_camera_far_away_still_hits_the_right_place(distance):
    """Rays start in single precision only where the scene begins. Double leaves 1e8 x 2^-52 = 2e-8 m of the origin."""
    scene = with_floor(
        "ORTHOGRAPHIC", (-1, 1, -1, 1), (0, 2 * distance), rotation([1, 0, 0], 30) @ translation(0, 0, distance)
    )
    picture = render(scene, 8, stop_rule="FIXED", light_samples=1)
    u = -1 + (np.arange(8) + 0.5) / 4
    np.testing.assert_allclose(picture.position[..., 0], np.broadcast_to(u, (8, 8)), atol=1e-5)
    np.testing.assert_allclose(
        picture.position[..., 1], np.broadcast_to(u[:, None] / np.cos(np.radians(30)), (8, 8)), atol=2e-5
    )


def test_background():
    """Where nothing is hit: the background's colour and alpha 1, or nothing at all if it is transparent."""
    scene = pn.Scene()
    add(scene, "plate", parallelogram([0, -1, 0], [1, 0, 0], [0, 2, 0]))
    look_down(scene, 1.0)
    scene.set_background((0.25, 0.5, 2.0))
    missed = render(scene, 8).passes
    np.testing.assert_array_equal(missed["Combined"][:, :4], np.broadcast_to([0.25, 0.5, 2.0, 1.0], (8, 4, 4)))
    np.testing.assert_array_equal(missed["Combined"][:, 4:], np.broadcast_to([0, 0, 0, 1.0], (8, 4, 4)))
    assert (missed["Depth"][:, :4] == NO_DEPTH).all() and (missed["Normal"][:, :4] == 0).all()
    scene.set_background((0.25, 0.5, 2.0), transparent=True)
    np.testing.assert_array_equal(render(scene, 8).passes["Combined"][:, :4], 0)


def test_empty_scene_is_background_only():
    scene = pn.Scene()
    look_down(scene)
    scene.set_background((1, 0.5, 0))
    picture = render(scene, 5)
    assert (picture.passes["Combined"] == [1, 0.5, 0, 1]).all()
    assert picture.statistics["primary_rays"] == 25 and picture.statistics["triangles"] == 0


def edge_coverage(x, pixel_samples, filter_type, filter_width, **more):
    """Alpha of 4 x 4 pixels from -2 to 2 over a plate that ends at x, nothing beyond."""
    scene = pn.Scene()
    add(scene, "plate", parallelogram([-10, -10, 0], [10 + x, 0, 0], [0, 20, 0]))
    look_down(scene, 2.0)
    scene.set_background((0, 0, 0), transparent=True)
    chosen = {"pixel_samples": pixel_samples, "filter_type": filter_type, "filter_width": filter_width}
    return render(scene, 4, **{"stop_rule": "FIXED", "light_samples": 1, **chosen, **more}).passes["Combined"][..., 3]


def test_box_filter_gives_coverage():
    """A plate's edge 30 % into a pixel: alpha is the covered share, 256 Owen-Sobol' places: 1/256. A filter of width 2
    reaches half a pixel further to each side."""
    for width, shares in ((1.0, [1, 1, 0.3, 0]), (2.0, [1, 0.9, 0.4, 0])):
        np.testing.assert_allclose(edge_coverage(0.3, 256, "BOX", width), np.broadcast_to(shares, (4, 4)), atol=1 / 256)


def test_bounded_keeps_the_tolerance_in_alpha_too():
    """The same plate; it is black, so that only its coverage tells where more rays are needed."""
    for x in (0.3, 0.71, 0.05):
        alpha = edge_coverage(x, 2, "BOX", 1.0, stop_rule="BOUNDED", error_tolerance=0.002)
        np.testing.assert_allclose(alpha, np.broadcast_to([1, 1, x, 0], (4, 4)), atol=0.002)


def test_blackman_harris_filter_gives_its_share():
    """An edge through the pixels' middle: half, by symmetry.

    And a quarter of its support, twice the width, away: the window's integral.
    """
    alpha = edge_coverage(0.5, 1024, "BLACKMAN_HARRIS", 2.0)
    x = (np.arange(20000) + 0.5) / 20000
    w = 0.35875 - 0.48829 * np.cos(2 * np.pi * x) + 0.14128 * np.cos(4 * np.pi * x) - 0.01168 * np.cos(6 * np.pi * x)
    left_of = np.cumsum(w) / w.sum()
    share = [left_of[14999], 0.5, left_of[4999]]  # the edge is a quarter of the width right of, in, left of the centre
    np.testing.assert_allclose(alpha[:, 1:], np.broadcast_to(share, (4, 3)), atol=2e-3)


def test_data_passes_are_not_filtered():
    scene = with_floor("PERSPECTIVE", WINDOWS["centred"])
    one = render(scene, WIDTH, HEIGHT, stop_rule="FIXED", pixel_samples=1).passes
    many = render(scene, WIDTH, HEIGHT, stop_rule="FIXED", pixel_samples=8).passes
    left, right, bottom, top = WINDOWS["centred"]
    pixel = max((right - left) / WIDTH, (top - bottom) / HEIGHT)
    # The first ray's place, somewhere within the filter: a pixel or two away on the floor 4 m off, never an average.
    assert np.abs(many["Position"] - one["Position"]).max() < 4 * 8 * pixel
    plane = (many["Position"] - VIEW[:3, 3]) @ -VIEW[:3, 2]
    np.testing.assert_allclose(many["Depth"][..., 0], plane, rtol=1e-5)


def test_scaled_camera_matrices_are_the_callers_business():
    """A matrix with a scale still renders; the ray's direction carries it, so that depth counts in scaled units."""
    plain = render(with_floor("PERSPECTIVE", WINDOWS["centred"]), 6)
    scaled = render(with_floor("PERSPECTIVE", WINDOWS["centred"], (0.005, 50.0), VIEW @ scaling(2, 2, 2)), 6)
    np.testing.assert_allclose(scaled.position, plain.position, atol=1e-5)
    np.testing.assert_allclose(2 * scaled.passes["Depth"], plain.passes["Depth"], rtol=1e-5)
