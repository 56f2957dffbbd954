# SPDX-License-Identifier: GPL-3.0-or-later
"""What a render says about itself must follow from the scene and the settings, and agree with its passes."""

import numpy as np
import penumbra_native as pn
import pytest
from scenes import add, box, floor, light_above, lit_floor, look_down, parallelogram, render, rotation, translation

WIDTH, HEIGHT = 20, 12


def scene(**changes):
    """A floor, two boxes of one mesh and a luminaire; `changes` replaces one thing at a time."""
    given = {
        "vertex": 0.0,
        "triangle": 0,
        "normals": None,
        "slots": None,
        "matrix": translation(1, 0, 0.2),
        "albedo": 0.5,
        "light": light_above(),
        "size": (1, 1),
        "radiance": (3, 3, 3),
        "shape": "RECTANGLE",
        "shadow": True,
        "half": 2.0,
        "background": (0, 0, 0),
        "transparent": False,
        "name": "box",
    }
    assert not set(changes) - set(given)
    given.update(changes)
    s = pn.Scene()
    add(s, "floor", floor(half=1.4))
    grey = s.add_material("grey", (given["albedo"],) * 3)
    positions, triangles = box([-0.2, -0.2, -0.2], [0.2, 0.2, 0.2])
    positions[7, 2] += given["vertex"]
    triangles = np.roll(triangles, given["triangle"], axis=0)
    mesh = s.add_mesh(given["name"], positions, triangles, given["normals"], given["slots"])
    s.add_instance(given["name"], mesh, translation(-1, 0, 0.2), [grey])
    s.add_instance(given["name"], mesh, given["matrix"], [grey])
    s.add_area_light("key", given["shape"], given["light"], given["size"], given["radiance"], given["shadow"])
    look_down(s, given["half"])
    s.set_background(given["background"], given["transparent"])
    return s


def hash_of(**changes):
    return render(scene(**changes), 1).statistics["scene_hash"]


def test_counts_of_the_scene():
    s = render(scene(), WIDTH, HEIGHT).statistics
    assert (s["triangles"], s["meshes"], s["instances"], s["luminaires"]) == (2 + 2 * 12, 2, 3, 1)
    assert s["version"] == pn.__version__ and s["build"] == pn.build and s["isa"] == pn.isa
    assert s["seconds"]["build"] >= 0 and s["seconds"]["render"] > 0
    assert s["warnings"] == [] and s["non_finite_pixels"] == 0


@pytest.mark.parametrize("samples", [1, 3])
def test_rays_add_up(samples):
    """FIXED: as many points as rays, pixels x samples x light_samples, where all face the luminaire."""
    s = render(lit_floor(), WIDTH, HEIGHT, stop_rule="FIXED", light_samples=20, pixel_samples=samples)
    pixels = WIDTH * HEIGHT
    assert s.statistics["primary_rays"] == pixels * samples
    assert s.statistics["light_points"] == pixels * samples * 20 == s.light_samples.sum()
    assert s.statistics["shadow_rays"] == s.statistics["light_points"]
    assert s.statistics["shadow_rays_beyond_stop"] == s.statistics["points_without_ray"] == 0
    assert s.statistics["mirror_rays"] == 0


def test_pixels_without_a_surface_cost_nothing():
    """A floor of 2.8 x 2.8 in a window of 4 x 4 and 20 x 20 pixels: 14 x 14 pixel centres hit it."""
    s = render(scene(), 20, stop_rule="FIXED", light_samples=16)
    hits = (s.passes["Depth"][..., 0] < 1e9).sum()
    assert hits == 14 * 14
    assert s.statistics["light_points"] == hits * 16 == s.light_samples.sum()


@pytest.mark.parametrize("rule", ["FIXED", "PAPER", "VARIANCE", "BOUNDED"])
def test_points_decided_without_a_ray(rule):
    """A luminaire behind the floor: each pixel's pair with it needs none."""
    s = render(lit_floor(light=translation(0, 0, -1)), WIDTH, HEIGHT, stop_rule=rule).statistics
    assert s["points_without_ray"] == WIDTH * HEIGHT
    assert s["shadow_rays"] == s["light_points"] == 0


@pytest.mark.parametrize("rule", ["FIXED", "BOUNDED"])
def test_pixels_that_are_not_finite_are_counted_named_and_black(rule):
    """Radiance 1e300 is none that float32 can hold; 1e30 is."""
    fine = render(lit_floor((1e30,) * 3), 4, stop_rule=rule)
    assert (fine.red > 1e27).all() and fine.statistics["non_finite_pixels"] == 0
    picture = render(lit_floor((1e300, 1, 1)), 4, stop_rule=rule)
    assert picture.statistics["non_finite_pixels"] == 16
    assert "pixel 0,0 (floor)" in picture.statistics["warnings"][0]
    assert all(np.isfinite(values).all() for values in picture.passes.values())


def test_error_estimate_follows_the_pass():
    """Mean, 99th percentile (order statistic) and maximum of the Error Estimate pass."""
    picture = render(scene(), WIDTH, HEIGHT, stop_rule="FIXED", sampler="PRS", light_samples=16)
    errors = np.sort(picture.passes["Error Estimate"], axis=None)
    estimate = picture.statistics["error_estimate"]
    assert estimate["mean"] == pytest.approx(errors.mean(), rel=1e-6)
    assert estimate["max"] == errors[-1]
    assert estimate["p99"] == errors[(errors.size - 1) * 99 // 100]
    assert picture.statistics["error_tolerance"] == pytest.approx(0.004)


def test_error_estimate_is_twice_the_standard_error_of_random_points():
    """PRS, 64 points: nearly normal errors, so about 4.6 % of them exceed twice their standard error; the estimate
    from 64 points adds half a percent. 3600 pixels: a binomial standard deviation of 0.36 %, four of them to each
    side."""
    picture = render(lit_floor(), 60, stop_rule="FIXED", sampler="PRS", light_samples=64)
    exact = render(lit_floor(), 60, stop_rule="FIXED", light_samples=4096).red
    exceeded = np.abs(picture.red - exact) > picture.passes["Error Estimate"][..., 0]
    assert 0.035 < exceeded.mean() < 0.065


CHANGES = {
    "vertex": 1e-6,
    "triangle": 1,
    "normals": np.ones((12, 3, 3), np.float32),
    "slots": np.ones(12, np.int32),
    "matrix": translation(1, 0, 0.2 + 1e-9),
    "albedo": 0.5 + 1e-9,
    "light": light_above() @ rotation([0, 0, 1], 1),
    "size": (1, 1 + 1e-9),
    "radiance": (3, 3, 3 + 1e-9),
    "shape": "ELLIPSE",
    "shadow": False,
    "half": 2 + 1e-9,
    "background": (0, 0, 1e-9),
    "transparent": True,
}


@pytest.mark.parametrize("what", CHANGES)
def test_hash_changes_with_the_scene(what):
    assert hash_of(**{what: CHANGES[what]}) != hash_of()


def test_hash_does_not_change_otherwise():
    """Built again, rendered again, with other settings, other names: the same."""
    once = scene()
    hashes = {
        render(once, 1).statistics["scene_hash"],
        render(once, 3, seed=9, stop_rule="FIXED").statistics["scene_hash"],
        hash_of(),
        hash_of(name="another name"),
    }
    assert len(hashes) == 1 and len(hashes.pop()) == 16


def test_order_of_instances_matters_to_the_hash_only():
    a, b = pn.Scene(), pn.Scene()
    plates = [parallelogram([x, -1, 0], [1, 0, 0], [0, 2, 0]) for x in (-1, 0)]
    for s, order in ((a, plates), (b, plates[::-1])):
        for i, plate in enumerate(order):
            add(s, f"plate {i}", plate)
        s.add_area_light("key", "RECTANGLE", light_above(), (1, 1), (1, 1, 1))
        look_down(s, 0.95)
    first, second = render(a, 8, stop_rule="FIXED"), render(b, 8, stop_rule="FIXED")
    assert (first.red == second.red).all()
    assert first.statistics["scene_hash"] != second.statistics["scene_hash"]


def test_estimated_error_while_rendering():
    """Of the pixels finished so far: their estimates' 99th percentile, in the end that of the statistics, counted in
    bins of 1/32 of their value."""
    job = pn.Render(scene(), {"width": 200, "height": 80, "passes": ["Error Estimate"], "threads": 1})
    assert job.estimated_error == 0
    job.start()
    finished = np.zeros((80, 200), bool)
    while not job.done:
        for x, y, width, height in job.wait(1.0):
            finished[y : y + height, x : x + width] = True
            assert 0 < job.estimated_error < 0.004 * (1 + 1 / 32)
    job.finish()
    exact = job.statistics()["error_estimate"]["p99"]
    assert finished.all() and 0 < exact <= job.estimated_error <= exact * (1 + 1 / 32)
