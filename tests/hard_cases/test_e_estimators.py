# SPDX-License-Identifier: GPL-3.0-or-later
"""Rows 50 to 52: the points of the sequences, and the promise where the oracle is exact."""

import numpy as np
import penumbra_native as pn
import pytest
from methods import SEQUENCES
from scenes import add, floor, light_above, look_down, parallelogram, render

BELOW_ONE = 1 - 2.0**-24


@pytest.mark.parametrize(("sampler", "reuse"), SEQUENCES)
def test_e50_points_lie_in_the_half_open_square(sampler, reuse):
    """2^18 points: no coordinate rounds to 1 in float32. The published sequences begin after the corner."""
    for stream in range(64):
        points = pn.sample_points(sampler, 4096, reuse, stream, stream)
        assert points.min() >= 0 and np.float32(points.max()) <= np.float32(BELOW_ONE)
    if reuse == "SAME" and sampler in ("SOBOL", "HALTON"):
        assert (pn.sample_points(sampler, 1, reuse, 0, 0) > 0).all()


@pytest.mark.parametrize("sampler", ["SOBOL", "HALTON", "OWEN_SOBOL"])
@pytest.mark.parametrize("reuse", ["SAME", "CONTINUED", "ROTATED", "SCRAMBLED"])
def test_e51_sequences_are_never_strided(sampler, reuse):
    """Two luminaires a pixel: each gets a whole sequence, not every second point of one, which fills half the square
    (the paper's figure 2). Of each luminaire's 64 points 4 lie in a sixteenth of either axis, or 2 to 6 after a
    rotation or from a sequence's odd places on."""
    for stream in range(8):  # pixel x luminaires + luminaire
        points = np.asarray(pn.sample_points(sampler, 64, reuse, 1, stream), float)
        for axis in (0, 1):
            counts = np.histogram(points[:, axis], bins=16, range=(0, 1))[0]
            assert counts.min() >= 2 and counts.max() <= 6, (stream, axis, counts)


def bars(centres, width):
    """A scene of a floor, thin bars half way to the luminaire, and a square luminaire; white is about 1."""
    scene = pn.Scene()
    add(scene, "floor", floor(8.0), albedo=0.8)
    for i, x in enumerate(centres):
        add(scene, f"bar {i}", parallelogram([x - width / 2, -50, 1], [width, 0, 0], [0, 100, 0]))
    radiance = 1 / (0.8 * visible_form_factor(0.0, 0.0, [(-0.5, 0.5)]))
    scene.add_area_light("key", "RECTANGLE", light_above(2), (1, 1), (float(radiance),) * 3)
    look_down(scene, 1.5, 0.9)
    return scene, radiance


def visible_form_factor(x, y, intervals):
    """Form factor of the parts [a, b] x [-1/2, 1/2] of the square at height 2 from floor points (x, y); arrays."""

    def corner(a, b):
        a, b = a / 2, b / 2
        ra, rb = np.sqrt(1 + a * a), np.sqrt(1 + b * b)
        return (a / ra * np.arctan(b / ra) + b / rb * np.arctan(a / rb)) / (2 * np.pi)

    total = 0.0
    for a, b in intervals:
        total = total + corner(b - x, 0.5 - y) - corner(a - x, 0.5 - y) - corner(b - x, -0.5 - y)
        total = total + corner(a - x, -0.5 - y)
    return total


def exact_picture(centres, width, radiance, n):
    """A bar over x hides from the floor point p what lies over 2 x - p: the square less those intervals."""
    c = ((np.arange(n) + 0.5) / n * 2 - 1) * 1.5
    x, y = np.meshgrid(c, c)
    total = visible_form_factor(x, y, [(-0.5, 0.5)])
    for centre in centres:
        low, high = (np.clip(2 * (centre + side * width / 2) - x, -0.5, 0.5) for side in (-1, 1))
        total = total - visible_form_factor(x, y, [(low, high)])
    return 0.8 * radiance * total


@pytest.mark.parametrize(("count", "width"), [(1, 0.5), (9, 0.05), (23, 0.012)])
def test_e52_coverage_where_the_oracle_is_exact(count, width):
    """320 x 320 pixels, more than 1e5, behind an edge, bars, thin bars: at most 1 % miss the tolerance, by a one-sided
    binomial test at 3 sigma; and at most 5 % are beyond the estimate."""
    centres = np.linspace(-1, 1, count) + 0.003 if count > 1 else [0.25]
    scene, radiance = bars(centres, width)
    n, tolerance = 320, 0.004
    picture, exact = render(scene, n, error_tolerance=tolerance), exact_picture(centres, width, radiance, n)
    error = np.abs(picture.red - exact)
    pixels = n * n
    for beyond, share in (
        (error > tolerance * np.maximum(1, exact), 0.01),
        (error > picture.passes["Error Estimate"][..., 0], 0.05),
    ):
        assert beyond.sum() <= share * pixels + 3 * np.sqrt(pixels * share * (1 - share)), beyond.mean()
    shadowed = exact < 0.98 * exact_picture([], width, radiance, n)
    assert shadowed.mean() > 0.1
