# SPDX-License-Identifier: GPL-3.0-or-later
"""The same picture bit for bit with any number of threads and however borders cut it: pairs of renders must be
equal.

The scene has shared and single meshes, a mirror, two luminaires, smooth normals and a background; the frame is 61 x
43, which no tile or bucket divides.
"""

import itertools

import numpy as np
import penumbra_native as pn
import pytest
from scenes import ALL_PASSES, add, box, floor, light_above, render, rotation, scaling, sphere, translation

WIDTH, HEIGHT = 61, 43
COMBINATIONS = [
    *itertools.product(
        ["FIXED"], ["PRS", "SPRS", "SOBOL", "HALTON", "OWEN_SOBOL"], ["SAME", "CONTINUED", "ROTATED", "SCRAMBLED"]
    ),
    *itertools.product(["PAPER", "VARIANCE"], ["PRS", "SOBOL", "HALTON", "OWEN_SOBOL"], ["CONTINUED", "SCRAMBLED"]),
    ("BOUNDED", "OWEN_SOBOL", "SCRAMBLED"),
]


def smooth_sphere():
    positions, triangles = sphere([0, 0, 0], 0.3, 12)
    return positions, triangles, (positions / 0.3)[triangles].astype(np.float32)


def build():
    scene = pn.Scene()
    add(scene, "floor", floor(columns=3))
    grey = scene.add_material("grey", (0.4, 0.5, 0.6))
    shiny = scene.add_material("shiny", (0.2, 0.2, 0.2), phong=(0.3, 0.3, 0.3), phong_exponent=30)
    mirror = scene.add_material("mirror", (0.1, 0.1, 0.1), mirror=(0.8, 0.8, 0.8))
    ball = scene.add_mesh("ball", *smooth_sphere())
    crate = scene.add_mesh("crate", *box([-0.2, -0.2, -0.2], [0.2, 0.2, 0.2]))
    for i, material in enumerate((grey, shiny, mirror)):
        scene.add_instance(f"ball {i}", ball, translation(i - 1, 0.2, 0.4) @ scaling(1, 1, 1 - 0.2 * i), [material])
        scene.add_instance(
            f"crate {i}", crate, translation(i - 0.6, -0.7, 0.3) @ rotation([1, 2, 3], 50 * i), [material]
        )
    scene.add_area_light("key", "RECTANGLE", light_above(), (1, 1), (3, 3, 3))
    scene.add_area_light("rim", "ELLIPSE", translation(-2, 0, 1) @ rotation([0, 1, 0], -70), (0.5, 1), (2, 1, 0.5))
    scene.set_camera(
        "PERSPECTIVE", translation(0, -4, 2) @ rotation([1, 0, 0], 65), (-0.45, 0.45, -0.3, 0.35), (0.1, 30)
    )
    scene.set_background((0.1, 0.2, 0.3))
    return scene


def bits(picture):
    return {name: picture.passes[name].astype(np.float32).tobytes() for name in ALL_PASSES}


def counts(statistics):
    names = (
        "primary_rays",
        "mirror_rays",
        "shadow_rays",
        "shadow_rays_beyond_stop",
        "light_points",
        "points_without_ray",
        "pixels_at_sample_limit",
        "scene_hash",
    )
    return [statistics[name] for name in names] + [statistics["error_estimate"][k] for k in ("mean", "p99", "max")]


def settings(rule, sampler, reuse):
    return {
        "stop_rule": rule,
        "sampler": sampler,
        "sample_reuse": reuse,
        "light_samples": 16,
        "max_light_samples": 64,
        "seed": 5,
        "error_tolerance": 0.02,
    }


@pytest.mark.parametrize("rule, sampler, reuse", COMBINATIONS)
def test_threads_and_borders(rule, sampler, reuse):
    """1, 2 and 3 threads, another Scene object, and four borders joined, whose edges cut tiles."""
    chosen = settings(rule, sampler, reuse)
    whole = render(build(), WIDTH, HEIGHT, threads=1, **chosen)
    scene = build()
    for threads in (2, 3):
        other = render(scene, WIDTH, HEIGHT, threads=threads, **chosen)
        assert bits(other) == bits(whole), f"{threads} threads"
        assert counts(other.statistics) == counts(whole.statistics)
    joined = {name: np.full_like(a, np.nan) for name, a in whole.passes.items()}
    rays = 0
    for x0, x1, y0, y1 in ((0, 29, 0, 11), (29, WIDTH, 0, 11), (0, 29, 11, HEIGHT), (29, WIDTH, 11, HEIGHT)):
        part = render(scene, WIDTH, HEIGHT, region=(x0, y0, x1 - x0, y1 - y0), **chosen)
        rays += part.statistics["primary_rays"]
        for name, a in part.passes.items():
            joined[name][y0:y1, x0:x1] = a
    for name in ALL_PASSES:
        assert (joined[name] == whole.passes[name]).all(), name
    # BOUNDED looks at pixels around a border as well, and does not write them.
    assert rays == whole.statistics["primary_rays"] or (rule == "BOUNDED" and rays > whole.statistics["primary_rays"])
    assert whole.statistics["mirror_rays"] > 0 and whole.statistics["non_finite_pixels"] == 0


@pytest.mark.parametrize("rule", ["PAPER", "BOUNDED"])
@pytest.mark.parametrize("filter_type", ["BOX", "BLACKMAN_HARRIS"])
def test_antialiased(filter_type, rule):
    """Several primary rays a pixel: their places belong to the pixel too."""
    chosen = {**settings(rule, "OWEN_SOBOL", "SCRAMBLED"), "pixel_samples": 5, "filter_type": filter_type}
    whole = render(build(), 23, 17, threads=1, **chosen)
    assert bits(render(build(), 23, 17, threads=3, **chosen)) == bits(whole)
    left = render(build(), 23, 17, region=(0, 0, 9, 17), **chosen)
    right = render(build(), 23, 17, region=(9, 0, 14, 17), **chosen)
    for name in ALL_PASSES:
        assert (np.concatenate([left.passes[name], right.passes[name]], axis=1) == whole.passes[name]).all(), name


@pytest.mark.parametrize("pixel_samples", [1, 2])
def test_large_pictures(pixel_samples):
    """From 65,536 pixels on blocks can be larger, and are for one thread, not for six nor for what a border leaves."""
    chosen = {**settings("BOUNDED", "OWEN_SOBOL", "SCRAMBLED"), "error_tolerance": 0.1, "pixel_samples": pixel_samples}
    whole = render(build(), 531, 519, threads=1, **chosen)
    other = render(build(), 531, 519, threads=6, **chosen)
    assert bits(other) == bits(whole)
    assert other.statistics["primary_rays"] > whole.statistics["primary_rays"], "the blocks were the same"
    part = render(build(), 531, 519, region=(101, 77, 150, 130), **chosen)
    for name in ALL_PASSES:
        assert (part.passes[name] == whole.passes[name][77:207, 101:251]).all(), name


def test_single_pixels():
    """Borders of one pixel each, in the corners and inside."""
    chosen = settings("FIXED", "OWEN_SOBOL", "SCRAMBLED")
    scene = build()
    whole = render(scene, WIDTH, HEIGHT, **chosen)
    for x, y in ((0, 0), (WIDTH - 1, 0), (0, HEIGHT - 1), (WIDTH - 1, HEIGHT - 1), (33, 20)):
        pixel = render(scene, WIDTH, HEIGHT, region=(x, y, 1, 1), **chosen)
        assert all((pixel.passes[n][0, 0] == whole.passes[n][y, x]).all() for n in ALL_PASSES)


def test_seeds_change_the_noise_only():
    """Another seed: other bits, the same geometry, nearly the same mean."""
    pictures = [
        render(build(), WIDTH, HEIGHT, **{**settings("FIXED", "OWEN_SOBOL", "SCRAMBLED"), "seed": s})
        for s in (0, -1, 2**31 - 1)
    ]
    for other in pictures[1:]:
        assert (other.red != pictures[0].red).any()
        assert (other.passes["Depth"] == pictures[0].passes["Depth"]).all()
        assert other.red.mean() == pytest.approx(pictures[0].red.mean(), rel=5e-3)


def test_passes_asked_for_do_not_matter():
    chosen = settings("PAPER", "OWEN_SOBOL", "SCRAMBLED")
    whole, alone = render(build(), WIDTH, HEIGHT, **chosen), render(build(), WIDTH, HEIGHT, **chosen, passes=[])
    assert list(alone.passes) == ["Combined"]
    assert (alone.passes["Combined"] == whole.passes["Combined"]).all()
