# SPDX-License-Identifier: GPL-3.0-or-later
"""Depth of field against the thin lens' own formulas.

A point x at depth z is seen, through the place p of the lens, at u = x / z - p (1 / z - 1 / f) of the window at z = 1
(of an orthographic camera: at x - p (1 - z / f)): a copy of the opening, |1 / z - 1 / f| (|1 - z / f|) times as large.
So the alpha of a plate's straight edge is the share of the opening on one side of a line. A box filter of a hundredth
of a pixel leaves that as it is. 1024 samples of an edge in the lens' two dimensions have a standard error of about
0.5 x 1024^-3/4 = 0.003; 0.02 is allowed.
"""

import numpy as np
import penumbra_native as pn
import pytest
from scenes import add, box, floor, light_above, parallelogram, render, rotation, translation

SAMPLES = {"stop_rule": "FIXED", "light_samples": 1, "pixel_samples": 1024, "filter_type": "BOX", "filter_width": 0.01}
RADIUS, FOCUS = 0.2, 3.0
OPENINGS = {"round": (0, 0.0, 1.0), "triangle": (3, 0.3, 1.0), "hexagon": (6, 0.0, 1.0), "wide": (5, 0.7, 0.5)}
WIDTH = 40


def edge(kind, z, opening, turn=0.0):
    """A half plane x < 0 at depth z, turned about the view axis, before a transparent background."""
    scene = pn.Scene()
    add(scene, "plate", parallelogram([-50, -50, -z], [50, 0, 0], [0, 100, 0]), rotation([0, 0, 1], turn))
    scene.set_background((0, 0, 0), transparent=True)
    scene.set_camera(kind, np.eye(4), (-0.3, 0.3, -0.3, 0.3), (0.01, 1000), (RADIUS, FOCUS, *opening))
    return scene


def opening_of(blades, turn, ratio):
    """Corners of a circle's or polygon's copy of radius 1, after Cycles: (N, 2)."""
    n = blades if blades >= 3 else 4096
    angle = turn + (np.arange(n) + 0.5) * 2 * np.pi / n
    return np.stack([np.cos(angle) / ratio, np.sin(angle)], axis=1)


def share_below(corners, offset):
    """Share of a convex polygon's area where x < offset: cut along the line, then the shoelace formula."""
    kept = []
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        if a[0] < offset:
            kept.append(a)
        if (a[0] < offset) != (b[0] < offset):
            kept.append(a + (b - a) * (offset - a[0]) / (b[0] - a[0]))

    def area(p):
        x, y = np.transpose(p)
        return 0.5 * abs(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))

    return area(kept) / area(corners) if len(kept) > 2 else 0.0


@pytest.mark.parametrize("turn", [0.0, 50.0])
@pytest.mark.parametrize("opening", OPENINGS.values(), ids=OPENINGS)
@pytest.mark.parametrize("z", [1.2, 2.0, 12.0])
@pytest.mark.parametrize("kind", ["PERSPECTIVE", "ORTHOGRAPHIC"])
def test_a_blurred_edge_is_the_share_of_the_opening(kind, z, opening, turn):
    alpha = render(edge(kind, z, opening, turn), WIDTH, 1, **SAMPLES).passes["Combined"][0, :, 3]
    u = (np.arange(WIDTH) + 0.5) / WIDTH * 0.6 - 0.3
    scale = RADIUS * (1 / z - 1 / FOCUS if kind == "PERSPECTIVE" else 1 - z / FOCUS)
    # Pixel u sees, through p, the plate's plane at z (u + scale p), on the plate where normal (u + scale p) < 0.
    normal = np.sign(scale) * np.array([np.cos(np.radians(turn)), np.sin(np.radians(turn))])
    corners = opening_of(*opening) @ np.stack([normal, [-normal[1], normal[0]]], axis=1)
    expected = [share_below(corners, -normal[0] * x / scale) for x in u]
    assert 0.05 < np.mean(expected) < 0.95
    np.testing.assert_allclose(alpha, expected, atol=0.02)


def test_what_is_in_focus_is_sharp():
    alpha = render(edge("PERSPECTIVE", FOCUS, (0, 0.0, 1.0)), WIDTH, 1, **SAMPLES).passes["Combined"][0, :, 3]
    np.testing.assert_array_equal(alpha, np.repeat([1, 0], WIDTH // 2))


def blurred_scene(aperture=(RADIUS, FOCUS, 5, 0.4, 0.8)):
    scene = pn.Scene()
    add(scene, "floor", floor(half=20))
    add(scene, "near", box([-0.6, 1.2, 0], [-0.3, 1.5, 0.9]))
    add(scene, "far", box([0.2, -3, 0], [1.0, -2.5, 2.0]))
    scene.add_area_light("key", "RECTANGLE", light_above(z=4, x=1), (1, 1), (20, 20, 20))
    view = translation(0, 3.5, 1.5) @ rotation([0, 0, 1], 180) @ rotation([1, 0, 0], 70)
    scene.set_camera("PERSPECTIVE", view, (-0.5, 0.5, -0.4, 0.4), (0.01, 100), aperture)
    return scene


@pytest.mark.parametrize("rule", ["FIXED", "PAPER", "VARIANCE", "BOUNDED"])
def test_one_ray_a_pixel_goes_through_the_middle(rule):
    settings = {"stop_rule": rule, "pixel_samples": 1}
    sharp, lens = (render(blurred_scene(a), 32, 24, **settings) for a in (None, (RADIUS, FOCUS, 5, 0.4, 0.8)))
    for name, values in sharp.passes.items():
        assert np.array_equal(values, lens.passes[name]), name


@pytest.mark.parametrize("rule", ["FIXED", "BOUNDED"])
def test_an_opening_of_no_size_changes_no_bit(rule):
    settings = {"stop_rule": rule, "pixel_samples": 4}
    sharp, lens = (render(blurred_scene(a), 32, 24, **settings) for a in (None, (0.0, FOCUS, 5, 0.4, 0.8)))
    assert sharp.statistics["scene_hash"] == lens.statistics["scene_hash"]
    for name, values in sharp.passes.items():
        assert np.array_equal(values, lens.passes[name]), name


@pytest.mark.parametrize("rule", ["FIXED", "BOUNDED"])
def test_same_picture_for_any_threads_and_borders(rule):
    settings = {"stop_rule": rule, "pixel_samples": 4, "light_samples": 4}
    whole = render(blurred_scene(), 40, 30, threads=1, **settings)
    assert np.array_equal(whole.red, render(blurred_scene(), 40, 30, threads=2, **settings).red)
    left = render(blurred_scene(), 40, 30, region=(0, 0, 17, 30), **settings)
    right = render(blurred_scene(), 40, 30, region=(17, 0, 23, 30), **settings)
    for name, values in whole.passes.items():
        assert np.array_equal(values, np.concatenate([left.passes[name], right.passes[name]], axis=1)), name


BAD = {"radius": (-1, 3, 0, 0, 1), "distance": (0.1, 0, 0, 0, 1), "ratio": (0.1, 3, 0, 0, 0),
       "rotation": (0.1, 3, 0, np.nan, 1)}  # fmt: skip


@pytest.mark.parametrize("numbers", BAD.values(), ids=BAD)
def test_bad_openings_are_refused(numbers, request):
    with pytest.raises(ValueError, match="camera: the") as error:
        blurred_scene(numbers)
    assert request.node.callspec.id in str(error.value)
