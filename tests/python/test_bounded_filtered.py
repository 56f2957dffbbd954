# SPDX-License-Identifier: GPL-3.0-or-later
"""The promise of BOUNDED with antialiasing: at least 99 % of the filtered pixels are within the tolerance.

Oracle: 4096 fixed primary rays a pixel with 8 points on each luminaire, another seed. Its own error at a full-contrast
edge is about 0.5 x 4096^-3/4 = 1e-3 at worst and a tenth of that in the mean, against tolerances of 0.02 and 0.004.
"""

import functools

import numpy as np
import pytest
from promise_scenes import blinds, ellipse_and_square, foliage, make, open_floor, slanted_fence, solid_objects, wires
from scenes import render
from test_bounded import most_misses

WIDTH, HEIGHT = 64, 48


@functools.cache
def reference(scene):
    settings = {"stop_rule": "FIXED", "pixel_samples": 4096, "light_samples": 8, "seed": 4711}
    return render(make(scene), WIDTH, HEIGHT, **settings).passes["Combined"]


def filtered(scene, **settings):
    return render(make(scene), WIDTH, HEIGHT, **{"stop_rule": "BOUNDED", "pixel_samples": 2, **settings})


@pytest.mark.parametrize("tolerance", [0.02, 0.004])
@pytest.mark.parametrize("scene", [open_floor, solid_objects, slanted_fence, wires, blinds, ellipse_and_square, foliage])
def test_coverage(scene, tolerance):
    picture, true = filtered(scene, error_tolerance=tolerance, max_pixel_samples=32768), reference(scene)
    error = np.abs(picture.passes["Combined"] - true).max(axis=-1)  # alpha, too
    missed = error > tolerance * np.maximum(1, true.max(axis=-1))
    assert missed.sum() <= most_misses(missed.size), f"{100 * missed.mean():.2f} % of the pixels"


@pytest.mark.parametrize("scene", [solid_objects, wires])
def test_one_ray_through_the_centre_fails_the_same_test(scene):
    missed = np.abs(filtered(scene, pixel_samples=1).red - reference(scene)[..., 0]) > 0.004
    assert missed.sum() > most_misses(missed.size)


@pytest.mark.parametrize("scene", [solid_objects, wires])
def test_error_estimate_is_a_bound(scene):
    picture = filtered(scene)
    error = np.abs(picture.passes["Combined"] - reference(scene)).max(axis=-1)
    assert (error <= picture.passes["Error Estimate"][..., 0]).mean() >= 0.95


def test_flat_parts_are_cheap():
    """Nothing to find on an open floor: the first look's rays, but for the horizon."""
    picture = filtered(open_floor)
    assert np.median(picture.light_samples) <= 4


def test_same_picture_for_any_threads_and_borders():
    whole = filtered(solid_objects, threads=1)
    assert np.array_equal(whole.red, filtered(solid_objects, threads=2).red)
    left = filtered(solid_objects, region=(0, 0, 29, HEIGHT))
    right = filtered(solid_objects, region=(29, 0, WIDTH - 29, HEIGHT))
    for name, values in whole.passes.items():
        assert np.array_equal(values, np.concatenate([left.passes[name], right.passes[name]], axis=1)), name
