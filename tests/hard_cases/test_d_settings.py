# SPDX-License-Identifier: GPL-3.0-or-later
"""What a Render refuses, always with the setting's name in the message, and before anything large is allocated."""

import gc

import numpy as np
import penumbra_native as pn
import pytest
from scenes import lit_floor, render

INVALID = {
    "width": [0, -1, 2**31, 1.5, "wide", None],
    "height": [0, -4, 2**40, float("nan")],
    "region": [
        (0, 0, 9, 8),
        (0, 0, 8, 9),
        (7, 0, 2, 1),
        (0, 0, 0, 0),
        (0, 0, 0, 4),
        (4, 4, 4, 0),
        (-1, 0, 4, 4),
        (0, 0, 4),
        (2**32 - 1, 0, 2, 2),
        "all",
    ],
    "stop_rule": ["", "fixed", "NEVER", 3, None],
    "sampler": ["", "FAURE", "sobol"],
    "sample_reuse": ["", "OFTEN", "same"],
    "light_samples": [0, -1, 2**24 + 1, 2**31, 2**40, 1.5, "many"],
    "max_light_samples": [0, -1, 2**31, 2**24 + 1],
    "check_interval": [0, -5, 2**31, 2**24 + 1],
    "pixel_samples": [0, -1, 2**31, 2**24 + 1],
    "filter_type": ["", "GAUSSIAN"],
    "filter_width": [0.0, -1.0, float("nan"), float("inf"), 11.0, "wide"],
    "mirror_depth": [-1, 2**31, 1025],
    "seed": [2**63, -(2**63) - 1, 1.5, "random"],
    "error_tolerance": [0.0, -0.1, float("nan"), float("inf"), "small"],
    "exposure": [float("nan"), float("inf"), 101.0, -101.0],
    "threads": [-1, 1025, 2**31],
}


@pytest.mark.parametrize("name, value", [(n, v) for n, values in INVALID.items() for v in values])
def test_d46_invalid_values_are_named(name, value):
    with pytest.raises(ValueError, match=name):
        pn.Render(lit_floor(), {"width": 8, "height": 8, "stop_rule": "FIXED", name: value})


def test_unknown_settings_and_passes():
    with pytest.raises(ValueError, match="light_sample'"):
        pn.Render(lit_floor(), {"width": 8, "height": 8, "light_sample": 4})
    with pytest.raises(ValueError, match="Ambient Occlusion"):
        pn.Render(lit_floor(), {"width": 8, "height": 8, "passes": ["Combined", "Ambient Occlusion"]})
    with pytest.raises(ValueError, match="width"):
        pn.Render(lit_floor(), {})


def test_d45_huge_frames_are_refused_before_allocation():
    """65536 x 65536 pixels would be 64 GB for Combined alone."""
    with pytest.raises(ValueError, match=r"width x height"):
        pn.Render(lit_floor(), {"width": 65536, "height": 65536})
    with pytest.raises(ValueError, match=r"width x height"):
        pn.Render(lit_floor(), {"width": 2**32 - 1, "height": 2**32 - 1, "region": (0, 0, 1, 1)})


def test_d45_odd_shapes_of_frames():
    assert render(lit_floor(), 1, 1).red.shape == (1, 1)
    assert render(lit_floor(), 1, 2000, stop_rule="FIXED", light_samples=1).red.shape == (2000, 1)
    part = render(lit_floor(), 32768, 32768, region=(32767, 32760, 1, 8), stop_rule="FIXED", light_samples=4)
    assert part.red.shape == (8, 1) and np.isfinite(part.red).all()


@pytest.mark.parametrize("seed", [0, -1, 2**31 - 1, -(2**31), 2**32 - 1, 2**63 - 1])
@pytest.mark.parametrize("sampler", ["PRS", "SOBOL", "HALTON", "OWEN_SOBOL"])
def test_d46_extreme_seeds(sampler, seed):
    picture = render(
        lit_floor(), 4, stop_rule="FIXED", light_samples=16, sampler=sampler, sample_reuse="CONTINUED", seed=seed
    )
    assert (picture.red > 0).all()


def test_blocks_outside_the_region_and_passes_not_rendered():
    job = pn.Render(lit_floor(), {"width": 8, "height": 6})
    job.start()
    job.finish()
    assert job.read("Combined", 2, 3, 4, 3).shape == (12, 4)
    for block in ((0, 0, 9, 1), (0, 0, 1, 7), (8, 0, 1, 1), (2**32 - 1, 0, 2, 1)):
        with pytest.raises(ValueError, match="region"):
            job.read("Combined", *block)
    with pytest.raises(ValueError, match="Depth"):
        job.read("Depth", 0, 0, 1, 1)


def test_read_blocks_equal_the_whole():
    job = pn.Render(lit_floor(), {"width": 70, "height": 66, "passes": ["Combined", "Position"]})
    job.start()
    tiles = []
    while not job.done:
        tiles += job.wait(1.0)
    job.finish()
    whole = job.passes()
    assert whole["Combined"].dtype == np.float32 and whole["Combined"].shape == (66, 70, 4)
    seen = np.zeros((66, 70), int)
    for x, y, w, h in tiles:
        seen[y : y + h, x : x + w] += 1
        for name, channels in (("Combined", 4), ("Position", 3)):
            np.testing.assert_array_equal(
                job.read(name, x, y, w, h).reshape(h, w, channels), whole[name][y : y + h, x : x + w]
            )
    assert (seen == 1).all(), "every pixel is reported once"
    assert job.progress == 1.0


def test_a_refused_render_leaves_the_scene_usable():
    scene = lit_floor()
    for _ in range(3):
        with pytest.raises(ValueError):
            pn.Render(scene, {"width": 8, "height": 8, "light_samples": 0})
    gc.collect()
    assert (render(scene, 4).red > 0).all()
