# SPDX-License-Identifier: GPL-3.0-or-later
"""examples/render.py: what it leaves, what it prints, how it fails."""

import json
import signal
import subprocess
import time

import bpy
import numpy as np
import pytest
from helpers import (
    HANGS_SECONDS,
    REPOSITORY,
    add_area_light,
    add_camera,
    add_plane,
    animate,
    blender_program,
    last_line,
    link,
    read_exr,
    run_blender,
)

SCRIPT = REPOSITORY / "examples" / "render.py"


@pytest.fixture
def blend_file(scene, tmp_path):
    """A lit plane, 64 x 48 pixels; the camera rises by 1 m a frame. The engine stored in the file is another one."""
    add_plane(scene, size=100)
    add_area_light(scene, location=(0, 0, 3))
    camera = add_camera(scene)
    animate(camera, "location", {frame: (0, 0, 4 + frame) for frame in (1, 11)})
    scene.render.engine = "CYCLES"
    scene.render.filepath = "//own_"
    (tmp_path / "work").mkdir()
    path = tmp_path / "work" / "scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), check_existing=False)
    return path


@pytest.fixture
def run(blend_file):
    """A function that runs render.py in the blend file's folder with these options."""
    return lambda *options: run_blender(blend_file, "-P", SCRIPT, "--", *options, cwd=blend_file.parent)


def pictures(blend_file) -> list[str]:
    """Every file beside the blend file."""
    return sorted(path.name for path in blend_file.parent.iterdir() if not path.name.startswith("scene.blend"))


def assert_fails(process, blend_file, text: str) -> None:
    """Exit code not 0, one last line that says why, and no file left."""
    assert process.returncode != 0
    assert last_line(process).startswith("render.py: ") and text in last_line(process)
    assert pictures(blend_file) == []


def test_a_picture_its_statistics_and_what_is_printed(run, blend_file):
    process = run(
        "--output", "out.exr", "--statistics", "s.json", "--view", "view.png", "--set", "seed=7", "stop_rule=FIXED"
    )
    assert process.returncode == 0, process.stdout + process.stderr
    assert pictures(blend_file) == ["out.exr", "s.json", "view.png"]
    pixels = read_exr(blend_file.parent / "out.exr")
    assert set(pixels) == {"Combined"} and pixels["Combined"].dtype == np.float32
    statistics = json.loads((blend_file.parent / "s.json").read_text())
    assert statistics["light_points"] == 64 * 48 * 64
    for text in (str(blend_file.parent / "out.exr"), "Seconds", "shadow", "Estimated error"):
        assert text in process.stdout


def test_multilayer(run, blend_file):
    assert run("--output", "out.exr", "--multilayer").returncode == 0
    assert set(read_exr(blend_file.parent / "out.exr")) >= {"Combined", "Depth", "Normal", "Position", "Light Samples"}


def test_without_output_the_scenes_own_path_and_format(run, blend_file):
    assert run("--frame", "5").returncode == 0
    assert pictures(blend_file) == ["own_0005.png"]


def test_frames(run, blend_file):
    assert run("--output", "f.exr", "--frames", "2-4", "--statistics", "s_##.json", "--multilayer").returncode == 0
    assert pictures(blend_file) == [*(f"f000{i}.exr" for i in (2, 3, 4)), *(f"s_0{i}.json" for i in (2, 3, 4))]
    for frame in (2, 3, 4):
        depth = read_exr(blend_file.parent / f"f000{frame}.exr")["Depth"]
        np.testing.assert_allclose(depth, 4 + frame, rtol=1e-5)


@pytest.mark.parametrize(
    ("options", "text"),
    [
        (["--set", "error_tolerence=1"], "error_tolerence: there is no such setting"),
        (["--set", "error_tolerance=low"], "error_tolerance: 'low' is not a number"),
        (["--set", "light_samples=2.5"], "light_samples: '2.5' is not an integer"),
        (["--set", "light_samples=0"], "light_samples: 0 is not between 1 and"),
        (["--set", "error_tolerance=nan"], "error_tolerance: nan is not between"),
        (["--set", "sampler=LATTICE"], "sampler: 'LATTICE' is none of PRS, SPRS, SOBOL, HALTON, OWEN_SOBOL"),
        (["--set", "seed"], "expected NAME=VALUE"),
        (["--set", "sampler=SPRS"], "SPRS"),
        (["--output", "nowhere/out.exr"], "nowhere does not exist"),
        (["--output", "/proc/out.exr"], "cannot save"),
        (["--output", "out.xyz"], "unknown extension '.xyz'"),
        (["--output", "out.png", "--multilayer"], "--multilayer needs an .exr file"),
        (["--output", "out.exr", "--statistics", "nowhere/s.json"], "statistics_file"),
    ],
)
def test_bad_options_end_in_one_line(run, blend_file, options, text):
    assert_fails(run(*options), blend_file, text)


@pytest.mark.parametrize(
    "options", [["--frames", "5-2"], ["--frame", "x"], ["--nonsense"], ["--frame", "1", "--frames", "1-2"]]
)
def test_the_command_line_is_checked(run, blend_file, options):
    assert run(*options).returncode == 2
    assert pictures(blend_file) == []


def test_a_broken_scene(scene, run, blend_file):
    scene.camera = link(scene, "Round", bpy.data.cameras.new("Round"))
    scene.camera.data.type = "PANO"
    bpy.ops.wm.save_as_mainfile(filepath=str(blend_file), check_existing=False)
    assert_fails(run("--output", "out.exr"), blend_file, "camera 'Round'")


def test_no_view_layer_is_rendered(scene, run, blend_file):
    scene.view_layers[0].use = False
    bpy.ops.wm.save_as_mainfile(filepath=str(blend_file), check_existing=False)
    assert_fails(run("--output", "out.exr"), blend_file, "scene 'Scene': no view layer is used for rendering")


def test_the_addon_is_there_before_a_file_that_was_saved_with_it(scene, blend_file):
    """Else Blender says "Error: Engine 'PENUMBRA' not available", a word that render farms fail on."""
    scene.render.engine = "PENUMBRA"
    bpy.ops.wm.save_as_mainfile(filepath=str(blend_file), check_existing=False)
    process = subprocess.run(
        [blender_program(), "-b", "--factory-startup", "-P", SCRIPT.with_name("penumbra_addon.py"), blend_file]
        + ["-P", SCRIPT, "--", "--output", "out.exr"],
        cwd=blend_file.parent, capture_output=True, text=True, timeout=HANGS_SECONDS,
    )  # fmt: skip
    assert process.returncode == 0 and pictures(blend_file) == ["out.exr"]
    assert "Error:" not in process.stdout + process.stderr


@pytest.mark.parametrize("options", [[], ["--multilayer"]])
def test_a_full_disk(blend_file, options):
    """Files may not grow beyond 8 KiB, as on a disk that is full: Blender itself reports nothing."""
    limit = "import resource, signal; signal.signal(signal.SIGXFSZ, signal.SIG_IGN);" \
            "resource.setrlimit(resource.RLIMIT_FSIZE, (8192, 8192))"  # fmt: skip
    process = run_blender(blend_file, "--python-expr", limit, "-P", SCRIPT, "--", "--output", "out.exr", *options,
                          cwd=blend_file.parent)  # fmt: skip
    assert_fails(process, blend_file, "")


def test_a_picture_of_an_earlier_run_survives_a_failure(run, blend_file):
    assert run("--output", "out.exr").returncode == 0
    before = (blend_file.parent / "out.exr").read_bytes()
    assert run("--output", "out.exr", "--set", "sampler=SPRS").returncode != 0
    assert (blend_file.parent / "out.exr").read_bytes() == before


def test_interrupting_leaves_nothing_behind(blend_file, tmp_path):
    started = tmp_path / "started"
    handler = (
        f"import bpy, pathlib; bpy.app.handlers.render_init.append(lambda *_: pathlib.Path({str(started)!r}).touch())"
    )
    arguments = ["--output", "out.exr", "--set", "stop_rule=FIXED", "light_samples=400000"]
    process = subprocess.Popen(
        [blender_program(), "-b", "--factory-startup", blend_file, "--python-expr", handler, "-P", SCRIPT, "--"]
        + arguments,
        cwd=blend_file.parent, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    deadline = time.monotonic() + HANGS_SECONDS
    while not started.exists() and time.monotonic() < deadline:
        time.sleep(0.1)
    time.sleep(1.0)  # into the render, which takes many times that
    process.send_signal(signal.SIGINT)
    start = time.monotonic()
    _, errors = process.communicate(timeout=HANGS_SECONDS)
    assert process.returncode != 0
    assert "render.py: the render was cancelled" in errors
    assert time.monotonic() - start < 60  # the whole render takes many minutes
    assert pictures(blend_file) == []
