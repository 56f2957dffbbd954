# SPDX-License-Identifier: GPL-3.0-or-later
"""PAPER and VARIANCE against literal one-by-one simulations in float64, with the pixels' own points.

Contributions differ from the engine's by float rounding of the summands, 3e-7 relative; counts must be equal, which
fails only where a comparison is that close to the tolerance, and values agree to 1e-6.
"""

import numpy as np
import oracles
import penumbra_native as pn
import pytest
from scenes import add, apply, floor, light_above, look_down, parallelogram, render, rotation

UP = np.array([0.0, 0.0, 1.0])
RADIANCE, RHO = np.array([3.0, 1.5, 0.2]), np.array([0.5, 0.8, 0.9])
LIGHT, SIZE = light_above() @ rotation([1, 0, 0], 15), (1.0, 0.8)
PLATE = (parallelogram([-0.2, -0.5, 1], [0.6, 0, 0.1], [0, 0.9, 0]), rotation(UP, 20))
WIDTH = 12


def scene(blocked):
    s = pn.Scene()
    grey = s.add_material("paint", tuple(RHO))
    s.add_instance("floor", s.add_mesh("floor", *floor()), np.eye(4), [grey])
    if blocked:
        add(s, "plate", *PLATE)
    s.add_area_light("key", "RECTANGLE", LIGHT, SIZE, tuple(RADIANCE))
    look_down(s, 1.2, 0.5)  # from below the plate
    return s


def contributions(picture, index, blocked, sampler, reuse, limit):
    """What each of the pixel's points adds: (limit, 3), r, g, b."""
    points = pn.sample_points(sampler, limit, reuse, seed=7, pixel=index[0] * WIDTH + index[1], samples_per_pixel=limit)
    f, places = oracles.summands(picture.position[index], UP, LIGHT, SIZE, points)
    if blocked:
        triangles = oracles.triangles_of(apply(PLATE[1], PLATE[0][0]), PLATE[0][1])
        f = f * ~oracles.occluded(np.broadcast_to(picture.position[index], places.shape), places, triangles)
    return f[:, None] * RADIANCE * RHO


def paper(values, t, eps):
    """Section 3.2 of the paper, word by word. Returns (count, mean, satisfied)."""
    total, before = np.zeros(3), None
    for n, value in enumerate(values, 1):
        total = total + value
        if n % t == 0:
            mean = total / n
            if before is not None and (np.abs(mean - before) < eps).all():
                return n, mean, True
            before = mean
    return len(values), total / len(values), False


def variance(values, eps):
    """sqrt(sample variance / n) < eps in each of r, g, b, n >= 10."""
    for n in range(10, len(values) + 1):
        if (np.sqrt(values[:n].var(axis=0, ddof=1) / n) < eps).all():
            return n, values[:n].mean(axis=0), True
    return len(values), values.mean(axis=0), False


def expect_literal(settings, rule, blocked):
    limit = settings["max_light_samples"]
    picture = render(scene(blocked), WIDTH, **settings)
    unsatisfied = 0
    for index in np.ndindex(picture.red.shape):
        values = contributions(picture, index, blocked, settings["sampler"], settings["sample_reuse"], limit)
        count, mean, satisfied = rule(values)
        assert picture.light_samples[index] == count, index
        # atol: a pixel may see next to nothing of the luminaire.
        np.testing.assert_allclose(picture.passes["Combined"][index][:3], mean, rtol=1e-6, atol=1e-7)
        unsatisfied += not satisfied
    assert picture.statistics["light_points"] == picture.light_samples.sum()
    assert picture.statistics["pixels_at_sample_limit"] == unsatisfied
    return picture


@pytest.mark.parametrize("blocked", [False, True], ids=["open", "blocked"])
@pytest.mark.parametrize(
    "sampler, reuse, t",
    [
        ("PRS", "SAME", 5),
        ("SOBOL", "SAME", 5),
        ("HALTON", "CONTINUED", 7),
        ("OWEN_SOBOL", "SCRAMBLED", 5),
        ("OWEN_SOBOL", "ROTATED", 16),
    ],
)
def test_paper_is_the_literal_rule(sampler, reuse, t, blocked):
    settings = {
        "stop_rule": "PAPER",
        "sampler": sampler,
        "sample_reuse": reuse,
        "check_interval": t,
        "seed": 7,
        "error_tolerance": 0.004,
        "max_light_samples": 512,
    }
    picture = expect_literal(settings, lambda values: paper(values, t, 0.004), blocked)
    assert picture.light_samples.min() >= 2 * t
    assert np.ptp(picture.light_samples) > 0 or not blocked  # the open floor may stop at 2 t everywhere


@pytest.mark.parametrize("blocked", [False, True], ids=["open", "blocked"])
@pytest.mark.parametrize("sampler, reuse", [("PRS", "SAME"), ("HALTON", "SCRAMBLED"), ("OWEN_SOBOL", "SCRAMBLED")])
def test_variance_is_the_literal_rule(sampler, reuse, blocked):
    settings = {
        "stop_rule": "VARIANCE",
        "sampler": sampler,
        "sample_reuse": reuse,
        "seed": 7,
        "error_tolerance": 0.01,
        "max_light_samples": 200,
    }
    picture = expect_literal(settings, lambda values: variance(values, 0.01), blocked)
    assert picture.light_samples.min() >= 10


def test_exposure_moves_the_tolerance():
    """eps is in display units: two stops up and four times the tolerance are the same rule on the same radiance."""
    common = {"stop_rule": "PAPER", "max_light_samples": 256}
    a = render(scene(True), WIDTH, error_tolerance=0.004, exposure=0.0, **common)
    b = render(scene(True), WIDTH, error_tolerance=0.016, exposure=2.0, **common)
    assert (a.light_samples == b.light_samples).all() and (a.red == b.red).all()
    np.testing.assert_allclose(4 * a.passes["Error Estimate"], b.passes["Error Estimate"], rtol=1e-6)


def test_fixed_is_constant():
    picture = render(scene(True), WIDTH, stop_rule="FIXED", light_samples=37)
    assert (picture.light_samples == 37).all()


def test_pixels_at_the_limit_are_counted():
    """A tolerance nobody meets: every pixel of the frame."""
    for rule in ("PAPER", "VARIANCE"):
        picture = render(scene(False), WIDTH, stop_rule=rule, sampler="PRS", error_tolerance=1e-9, max_light_samples=37)
        assert (picture.light_samples == 37).all()
        assert picture.statistics["pixels_at_sample_limit"] == WIDTH * WIDTH


def test_rays_beyond_the_stop_are_counted_apart():
    """Packets of 16: every pixel here faces the luminaire with all points, so rays = points + those beyond the
    stop."""
    s = render(scene(False), WIDTH, stop_rule="PAPER", max_light_samples=512).statistics
    assert s["shadow_rays"] == s["light_points"] + s["shadow_rays_beyond_stop"]
    assert 0 < s["shadow_rays_beyond_stop"] < 16 * WIDTH * WIDTH
