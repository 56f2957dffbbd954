# SPDX-License-Identifier: GPL-3.0-or-later
"""Starting, stopping and dropping renders. None of these tests measures time: a cancel that did not work would show
as a finished picture, or as a suite that takes minutes."""

import gc
import threading

import numpy as np
import penumbra_native as pn
import pytest
from scenes import add, light_above, lit_floor, parallelogram, render

# 2^36 shadow rays: a quarter of an hour. One tile of 8 x 8 pixels: a tenth of a second.
ENDLESS = {"width": 1024, "height": 1024, "stop_rule": "FIXED", "light_samples": 2**16, "threads": 2}


@pytest.mark.parametrize("when", ["at once", "in the middle"])
def test_cancel(when):
    scene = lit_floor()
    expected = render(lit_floor(), 16).passes["Combined"]
    job = pn.Render(scene, ENDLESS)
    job.start()
    if when == "in the middle":
        while job.progress == 0:
            job.wait(0.01)
    job.cancel()
    job.finish()
    while not job.done:
        job.wait(0.1)
    assert job.progress < 0.5
    assert np.isfinite(job.passes()["Combined"]).all()
    assert job.statistics()["primary_rays"] < 0.5 * 1024 * 1024
    job.finish()  # twice is fine
    assert (render(scene, 16).passes["Combined"] == expected).all()


# One block, of which the first look is done at once and what follows takes many minutes.
LONG_BLOCKS = {
    "bounded": {"stop_rule": "BOUNDED", "error_tolerance": 1e-9, "max_light_samples": 2**24},
    "bounded antialiased": {
        "stop_rule": "BOUNDED", "error_tolerance": 1e-9, "pixel_samples": 64, "max_pixel_samples": 2**24,
        "max_light_samples": 2**24,
    },
    "fixed": {"stop_rule": "FIXED", "light_samples": 2**24},
    "paper": {"stop_rule": "PAPER", "error_tolerance": 1e-30, "max_light_samples": 2**24},
    "pixel samples": {"stop_rule": "FIXED", "light_samples": 16, "pixel_samples": 2**20},
}  # fmt: skip


@pytest.mark.parametrize("name", LONG_BLOCKS)
def test_cancel_inside_a_block(name):
    """The picture is one block: cancelled it ends at once, nothing of it is written, and the next render is right."""
    scene = lit_floor()
    add(scene, "blocker", parallelogram([-0.5, -0.5, 1], [1, 0, 0], [0, 1, 0]))
    job = pn.Render(scene, {"width": 64, "height": 64, "threads": 1, **LONG_BLOCKS[name]})
    job.start()
    assert job.wait(0.2) == []
    job.cancel()
    job.finish()
    assert job.done and (job.passes()["Combined"] == 0).all()
    again = {"width": 16, "stop_rule": "FIXED"}
    other = lit_floor()
    add(other, "blocker", parallelogram([-0.5, -0.5, 1], [1, 0, 0], [0, 1, 0]))
    assert (render(scene, **again).red == render(other, **again).red).all()


def test_dropping_a_running_render():
    scene = lit_floor()
    expected = render(lit_floor(), 16).passes["Combined"]
    for _ in range(3):
        job = pn.Render(scene, ENDLESS)
        job.start()
        job.wait(0.01)
        del job
        gc.collect()
    assert (render(scene, 16).passes["Combined"] == expected).all()


def test_dropping_the_scene_of_a_running_render():
    """The render keeps what it needs."""
    scene = lit_floor()
    job = pn.Render(scene, {"width": 64, "height": 64, "stop_rule": "FIXED", "light_samples": 1024})
    del scene
    gc.collect()
    job.start()
    job.finish()
    expected = render(lit_floor(), 64, stop_rule="FIXED", light_samples=1024).passes["Combined"]
    assert (job.passes()["Combined"] == expected).all()


def test_a_render_that_was_never_started():
    job = pn.Render(lit_floor(), ENDLESS)
    assert job.wait(0.0) == [] and job.progress == 0
    assert (job.passes()["Combined"] == 0).all()
    job.cancel()
    job.finish()
    del job
    gc.collect()


@pytest.mark.parametrize("seconds", [1e30, float("inf"), float("nan")])
def test_waiting_without_end_waits_for_the_first_block(seconds):
    job = pn.Render(lit_floor(), {"width": 64, "height": 64, "stop_rule": "FIXED", "light_samples": 1024})
    job.start()
    assert job.wait(seconds) != []
    job.finish()


def test_starting_twice_is_starting_once():
    job = pn.Render(lit_floor(), {"width": 16, "height": 16, "stop_rule": "FIXED"})
    job.start()
    job.start()
    job.finish()
    assert job.statistics()["primary_rays"] == 256


def test_scene_changes_after_a_render_was_made_do_not_reach_it():
    scene = lit_floor()
    job = pn.Render(scene, {"width": 8, "height": 8, "stop_rule": "FIXED"})
    scene.add_area_light("late", "RECTANGLE", light_above(3), (1, 1), (9, 9, 9))
    job.start()
    job.finish()
    first = render(lit_floor(), 8, stop_rule="FIXED").passes["Combined"]
    assert (job.passes()["Combined"] == first).all()
    assert (render(scene, 8, stop_rule="FIXED").red > first[..., 0]).all()


def test_renders_at_the_same_time():
    """Two renders of one scene from two Python threads; waiting releases the interpreter."""
    scene = lit_floor()
    expected = render(lit_floor(), 48, stop_rule="FIXED", light_samples=256).passes["Combined"]
    results = [None, None]

    def work(i):
        results[i] = render(scene, 48, stop_rule="FIXED", light_samples=256).passes["Combined"]

    render(scene, 1)  # the acceleration structure is built by one
    threads = [threading.Thread(target=work, args=(i,)) for i in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all((r == expected).all() for r in results)


def test_memory_does_not_grow_with_renders():
    """Fifty renders of a scene and fifty scenes: the process keeps less than 20 MB more than after the first ones."""

    def resident():
        with open("/proc/self/statm") as statm:
            return int(statm.read().split()[1]) * 4096

    def once(scene):
        render(scene, 256, stop_rule="FIXED", light_samples=1)

    scene = lit_floor()
    for _ in range(5):
        once(scene)
        once(lit_floor())
    before = resident()
    for _ in range(50):
        once(scene)
        once(lit_floor())
    gc.collect()
    assert resident() - before < 20e6
