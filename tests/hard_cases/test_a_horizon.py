# SPDX-License-Identifier: GPL-3.0-or-later
"""Row 5 with blockers: luminaires mostly below the receiver's horizon, where few points tell of what is left."""

import numpy as np
import oracles
import penumbra_native as pn
import pytest
from methods import ANTIALIASED, BOUNDED, UP, centres, look_at, patch
from scenes import add, parallelogram, render, rotation, translation

RHO, WALL, FENCE = 0.5, 1.5, 0.7
WIDTH, POSTS = 0.1, np.linspace(-0.9, 0.9, 7)
FACING_LEFT = np.array([[0, 0, 1, 0], [0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 0, 1.0]])


def sunk_wall(shape, above):
    """A wall of light, 1 m high and 2 m wide, of which so much is above the floor, behind a fence; and the outline of
    that part."""
    scene = patch(2, RHO)
    for i, y in enumerate(POSTS):
        add(scene, f"post {i}", parallelogram([FENCE, y - WIDTH / 2, 0], [0, WIDTH, 0], [0, 0, 9]))
    place, size = translation(WALL, 0, above - 0.5) @ FACING_LEFT, (1, 2)
    scene.add_area_light("wall", shape, place, size, (1, 1, 1))
    corners = {"RECTANGLE": oracles.rectangle_corners, "ELLIPSE": oracles.ellipse_corners}[shape](place, size)
    return scene, oracles.clip(corners[:: max(1, len(corners) // 256)], np.zeros(3), UP)


def form_factor(at, outline):
    """Of the wall less the posts' shadows on it, by Lambert's formula."""
    whole = oracles.lambert(outline, at, UP)
    if at[0] >= FENCE:
        return whole
    spread = (WALL - at[0]) / (FENCE - at[0])
    for y in POSTS:
        left, right = (np.array([0, at[1] + (y + side * WIDTH / 2 - at[1]) * spread, 0]) for side in (-1, 1))
        hidden = oracles.cut_by_shadow(outline, [(left, [0, 1, 0]), (right, [0, -1, 0])])
        whole -= oracles.lambert(hidden, at, UP)
    return whole


def exact(outline, n, inside):
    """Pixels of centres(), each the mean of inside x inside points."""
    at = centres(0, 0, 1.2, n * inside).reshape(-1, 3)
    return RHO * np.array([form_factor(p, outline) for p in at]).reshape(n, inside, n, inside).mean((1, 3))


@pytest.mark.parametrize(
    ("shape", "above"),
    [("RECTANGLE", 0.5), ("RECTANGLE", 0.1), ("RECTANGLE", 0.03), ("ELLIPSE", 0.1), ("ELLIPSE", 0.03)],
)
@pytest.mark.parametrize("rule", [BOUNDED, {**ANTIALIASED, "filter_type": "BOX", "filter_width": 1.0}])
def test_a05_behind_a_fence_mostly_below_the_horizon(shape, above, rule):
    """White is the brightest pixel. At most 1 % miss the tolerance, by a one-sided binomial test at 3 sigma, of those
    below max_light_samples and max_pixel_samples; at most 2 % reach these, since one point in 100 of the ellipse
    counts. At most 1 % are beyond twice the estimate: 0 to 0.5 % with four seeds.

    What each part of this guards: before points below the horizon were told from hidden ones, 6 % missed the tolerance
    with a centre ray and 64 % antialiased. Before a rectangle's points were taken from the part above the horizon, up
    to 3.5 %, with up to 4.8 % beyond twice the estimate. Before pixels that met one point above in four counted as
    unproven, 1.8 % of the ellipse's pixels were wrong by up to 0.03 where 0.00001 was claimed."""
    n, inside = (40, 1) if rule is BOUNDED else (20, 4)
    (scene, outline), tolerance = sunk_wall(shape, above), 0.004 if rule is BOUNDED else 0.02
    look_at(scene, 0, 0, 1.2, 8)
    reference = exact(outline, n, inside)
    white = reference.max()
    picture = render(scene, n, exposure=-np.log2(white), error_tolerance=tolerance, **rule)
    error, claimed = np.abs(picture.red - reference) / white, picture.passes["Error Estimate"][..., 0]
    sure = claimed <= tolerance
    assert sure.mean() > 0.98
    missed, pixels = (error[sure] > tolerance).sum(), sure.sum()
    assert missed <= 0.01 * pixels + 3 * np.sqrt(0.01 * pixels), missed / pixels
    assert (error > 2 * claimed).mean() < 0.01


@pytest.mark.parametrize("rule", [BOUNDED, ANTIALIASED])
@pytest.mark.parametrize("tilt", [10, 40, 80, 100, 140, 170])
def test_a05_half_the_sky_behind_the_back(tilt, rule):
    """A sun of 180 degrees from straight below: its part above a turned patch's horizon sends (1 - cos) / 2 of the
    whole. A pixel whose four first points lay below it was black before."""
    scene = pn.Scene()
    add(scene, "patch", parallelogram([-0.2, -0.2, 0], [0.4, 0, 0], [0, 0.4, 0]), rotation([1, 0, 0], tilt))
    scene.add_sun("ground", (0, 0, -1), np.pi, (np.pi,) * 3)
    facing = np.cos(np.radians(tilt)) * (1 if tilt < 90 else -1)  # sides turn towards the viewer
    look_at(scene, 0, 0, 0.01, 0.9)
    np.testing.assert_allclose(render(scene, 8, **rule).red, RHO * (1 - facing) / 2, rtol=1e-5)
