# SPDX-License-Identifier: GPL-3.0-or-later
"""The oracles against published constants, sum rules and each other: nothing here runs the engine."""

import numpy as np
import oracles
import pytest
from scenes import box, rotation, scaling, translation

UP = np.array([0.0, 0.0, 1.0])
CUBE_FACES = {
    "top": [(0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)],
    "south": [(0, 0, 0), (1, 0, 0), (1, 0, 1), (0, 0, 1)],
    "north": [(0, 1, 0), (1, 1, 0), (1, 1, 1), (0, 1, 1)],
    "west": [(0, 0, 0), (0, 1, 0), (0, 1, 1), (0, 0, 1)],
    "east": [(1, 0, 0), (1, 1, 0), (1, 1, 1), (1, 0, 1)],
}


def mean_over_cube_floor(polygon, n=48):
    """Gauss-Legendre in both directions; y = s^2 smooths the kink along the edge that touches the south face."""
    x, w = np.polynomial.legendre.leggauss(n)
    x, w = (x + 1) / 2, w / 2
    return sum(
        wi * wj * 2 * t * oracles.lambert(polygon, np.array([s, t * t, 0.0]), UP)
        for s, wi in zip(x, w, strict=True)
        for t, wj in zip(x, w, strict=True)
    )


@pytest.mark.parametrize("face, exact", [("top", 0.19982489569838724), ("south", 0.20004377607540313)])
def test_unit_cube(face, exact):
    """Published factors between cube faces; the quadrature leaves 1e-7 next to the edge."""
    assert mean_over_cube_floor(np.array(CUBE_FACES[face], float)) == pytest.approx(exact, rel=1e-6)


def test_everything_around_adds_up_to_one():
    """From any floor point of a closed room the other five faces are all there is: 1, to rounding."""
    for x, y in np.random.default_rng(1).uniform(0.01, 0.99, (50, 2)):
        total = sum(oracles.lambert(np.array(p, float), np.array([x, y, 0]), UP) for p in CUBE_FACES.values())
        assert total == pytest.approx(1, abs=1e-12)


def test_constants_of_closed_forms():
    """Ten published digits; a wall's foot from 1e-6 m away (E / L_e = 1.5707939, 8 digits)."""
    corner_over_point = oracles.parallel_rectangle(0.5, 0.5, 0.5, 1.0)
    assert corner_over_point == pytest.approx(0.138531606, abs=5e-10)
    assert oracles.perpendicular_rectangle(1, 1, 1) == pytest.approx(0.055734197, abs=5e-10)
    assert 2 * np.pi * oracles.perpendicular_rectangle(1, 0.5, 1e-6) == pytest.approx(1.5707939, abs=5e-8)
    wall = np.array([(1e-6, -0.5, 0), (1e-6, 0.5, 0), (1e-6, 0.5, 1), (1e-6, -0.5, 1)])
    assert np.pi * oracles.lambert(wall, np.zeros(3), UP) == pytest.approx(1.5707939, abs=5e-8)


def test_lambert_equals_the_special_forms():
    """Same quantity by other formulas, in double: 1e-11. The ellipse's polygon falls short by 1e-7 of its area,
    which counts more for points that see its edge from near: 2e-6."""
    random = np.random.default_rng(2)
    for _ in range(100):
        half, h = random.uniform(0.1, 2, 2)
        x, y = random.uniform(-3, 3, 2)
        square = oracles.rectangle_corners(translation(0, 0, h), (2 * half, 2 * half))
        assert oracles.lambert(square, np.array([x, y, 0]), UP) == pytest.approx(
            oracles.parallel_rectangle(x, y, half, h), rel=1e-11
        )
        round_light = oracles.ellipse_corners(translation(0, 0, h), (2 * half, 2 * half))
        assert oracles.lambert(round_light, np.array([x, y, 0]), UP) == pytest.approx(
            oracles.disk(half, h, np.hypot(x, y)), rel=2e-6
        )


def test_lambert_does_not_mind_rotation_or_size():
    random = np.random.default_rng(3)
    light = oracles.rectangle_corners(translation(0.3, -0.2, 1.5) @ rotation([1, 2, 0], 30), (1, 2))
    expected = oracles.lambert(light, np.zeros(3), UP)
    for _ in range(20):
        turn = rotation(random.normal(size=3), random.uniform(0, 180)) @ scaling(7, 7, 7)
        turned = light @ turn[:3, :3].T
        assert oracles.lambert(turned, np.zeros(3), turn[:3, 2] / 7) == pytest.approx(expected, rel=1e-12)


def test_clipping_at_the_horizon():
    """A wall reaching below the floor counts from the floor up; one wholly below counts nothing."""
    wall = np.array([(1, -1, -3), (1, 1, -3), (1, 1, 2), (1, -1, 2)], float)
    upper = wall.copy()
    upper[:2, 2] = 0
    assert oracles.lambert(wall, np.zeros(3), UP) == pytest.approx(oracles.lambert(upper, np.zeros(3), UP), rel=1e-13)
    assert oracles.lambert(wall - [0, 0, 5], np.zeros(3), UP) == 0


def test_brute_force_finds_what_slabs_find():
    """Rays against the twelve triangles of a box and against its three pairs of planes."""
    random = np.random.default_rng(4)
    low, high = np.array([-0.5, -0.3, -0.2]), np.array([0.4, 0.6, 0.7])
    a, b = random.uniform(-2, 2, (2, 5000, 3))
    found = oracles.occluded(a, b, oracles.triangles_of(*box(low, high)))
    t = np.sort([(low - a) / (b - a), (high - a) / (b - a)], axis=0)
    enter, leave = t[0].max(axis=1), t[1].min(axis=1)
    crosses_surface = (enter < leave) & (((enter > 0) & (enter < 1)) | ((leave > 0) & (leave < 1)))
    assert (found == crosses_surface).all() and 200 < found.sum() < 4000


def test_summands_average_to_the_form_factor():
    """Midpoint rule, 200 x 200: 1e-4."""
    g = (np.arange(200) + 0.5) / 200
    points = np.stack(np.meshgrid(g, g), axis=-1).reshape(-1, 2)
    matrix = translation(0.2, 0.1, 1.5) @ rotation([1, 1, 0], 20) @ scaling(1, -2, 1)
    f, _ = oracles.summands(np.zeros(3), UP, matrix, (1, 0.5), points)
    assert f.mean() == pytest.approx(
        oracles.lambert(oracles.rectangle_corners(matrix, (1, 0.5)), np.zeros(3), UP), rel=1e-4
    )
