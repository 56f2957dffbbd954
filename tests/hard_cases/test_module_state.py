# SPDX-License-Identifier: GPL-3.0-or-later
"""The module's objects in every order of calls, and when memory runs out: an error, and never a wrong picture."""

import numpy as np
import penumbra_native as pn
import pytest
from processes import run_code
from scenes import add, floor, lit_floor, render

SMALL = {"width": 8, "height": 8, "stop_rule": "FIXED"}


def test_done_is_false_before_the_start():
    job = pn.Render(lit_floor(), SMALL)
    assert not job.done and job.wait(0.0) == [] and not job.done
    job.start()
    job.finish()
    assert not job.done  # its one bucket was not reported yet
    assert job.wait(0.0) == [(0, 0, 8, 8)] and job.done


def test_done_of_a_cancelled_render_that_never_started():
    job = pn.Render(lit_floor(), SMALL)
    job.cancel()
    job.finish()
    assert not job.done
    job.start()
    job.finish()
    assert job.done and job.progress == 0 and (job.passes()["Combined"] == 0).all()


@pytest.mark.parametrize("what", ["picture", "structure"])
def test_a_memory_limit_is_an_error_that_names_it(what):
    scene = lit_floor()
    if what == "structure":
        add(scene, "carpet", floor(columns=300))
    size = {"width": 1024, "height": 1024} if what == "picture" else {}
    with pytest.raises(MemoryError, match="memory_limit of 4 MiB reached: .*" + what.replace("geometry", "carpet")):
        pn.Render(scene, {**SMALL, **size, "memory_limit": 4})
    assert (render(lit_floor(), 8, memory_limit=4).red > 0).all()


def test_a_scene_whose_build_failed_is_not_rendered_as_if_it_were_empty():
    scene = lit_floor()
    add(scene, "carpet", floor(columns=300))
    with pytest.raises(MemoryError):
        pn.Render(scene, {**SMALL, "memory_limit": 4})
    with pytest.raises(ValueError, match="ray tracing structure failed before"):
        pn.Render(scene, SMALL)


def test_no_memory_at_all_is_an_error_too():
    """A mesh of 100 MiB in a process that may not grow by more than 64 MiB."""
    process = run_code("""
        import resource
        import numpy as np
        import penumbra_native as pn
        from scenes import floor, lit_floor, render
        scene = lit_floor()
        corners = np.zeros((1, 3), np.float32)
        many = np.broadcast_to(np.zeros((1, 3), np.int32), (9_000_000, 3))
        render(scene, 8)
        used = int(open("/proc/self/statm").read().split()[0]) * 4096
        resource.setrlimit(resource.RLIMIT_AS, (used + 2**26, -1))
        try:
            pn.Scene().add_mesh("many", corners, many)
        except MemoryError as error:
            print("refused:", error)
        print(render(scene, 8).red.min() > 0)
    """)
    assert process.returncode == 0, process.stderr
    assert process.stdout.startswith("refused: ") and process.stdout.endswith("True\n")


def test_arrays_may_go_once_they_were_given():
    """Freed, overwritten and unmapped arrays: the scene has copies."""
    positions, triangles = floor()
    matrix, light = np.eye(4), np.eye(4)
    light[2, 3] = 2
    scene = pn.Scene()
    grey = scene.add_material("grey", (0.5,) * 3)
    scene.add_instance("floor", scene.add_mesh("floor", positions, triangles), matrix, [grey])
    scene.add_area_light("key", "RECTANGLE", light, (1, 1), (3, 3, 3))
    camera = np.eye(4)
    camera[2, 3] = 50
    scene.set_camera("ORTHOGRAPHIC", camera, (-2, 2, -2, 2), (0.05, 100))
    for array in (positions, triangles, matrix, light, camera):
        array[...] = 7
    del positions, triangles, matrix, light, camera, array
    assert (render(scene, 8, stop_rule="FIXED").red == render(lit_floor(), 8, stop_rule="FIXED").red).all()
