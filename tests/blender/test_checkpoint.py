# SPDX-License-Identifier: GPL-3.0-or-later
"""render.py --checkpoint: killed and started again; frames and view layers each have their own folder."""

import subprocess
import time

import bpy
import pytest
from helpers import (
    HANGS_SECONDS,
    REPOSITORY,
    add_area_light,
    add_camera,
    add_cube,
    add_plane,
    blender_program,
    last_line,
    read_exr,
    run_blender,
)

SCRIPT = REPOSITORY / "examples" / "render.py"


@pytest.fixture
def blend_file(scene, tmp_path):
    """A cube on a plane, 160 x 120 pixels, six buckets, about a second; two view layers."""
    add_plane(scene, size=100)
    add_cube(scene, size=1)
    add_area_light(scene, location=(0, 0, 3))
    add_camera(scene)
    scene.render.resolution_x, scene.render.resolution_y = 160, 120
    scene.penumbra.stop_rule, scene.penumbra.light_samples = "FIXED", 2048
    scene.view_layers.new("a/b")
    path = tmp_path / "scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), check_existing=False)
    return path


def test_kill_and_go_on(blend_file, tmp_path):
    checkpoint = tmp_path / "checkpoint"
    options = ["--multilayer", "--checkpoint", checkpoint, "--output"]
    command = [blender_program(), "-b", "--factory-startup", blend_file, "-P", SCRIPT, "--", *options, "k.exr"]
    process = subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    deadline = time.monotonic() + HANGS_SECONDS
    while not list(checkpoint.glob("*/*/bucket_*.bin")) and time.monotonic() < deadline:
        time.sleep(0.01)
    process.kill()
    process.wait()
    kept = {path: path.stat().st_mtime_ns for path in checkpoint.glob("*/*/bucket_*.bin")}
    assert kept and not (tmp_path / "k.exr").exists()

    resumed = run_blender(blend_file, "-P", SCRIPT, "--", *options, "k.exr", cwd=tmp_path)
    assert resumed.returncode == 0, resumed.stdout + resumed.stderr
    assert {path: path.stat().st_mtime_ns for path in kept} == kept, "a finished tile was rendered again"
    assert sorted(path.name for path in (checkpoint / "frame_0001").iterdir()) == ["layer_0", "layer_1"]
    reference = run_blender(blend_file, "-P", SCRIPT, "--", "--multilayer", "--output", "r.exr", cwd=tmp_path)
    assert reference.returncode == 0
    whole, again = read_exr(tmp_path / "r.exr"), read_exr(tmp_path / "k.exr")
    assert whole.keys() == again.keys() and {name.split(".")[0] for name in whole} == {"ViewLayer", "a/b"}
    assert all(whole[name].tobytes() == again[name].tobytes() for name in whole)


def test_another_scenes_checkpoint_is_refused(blend_file, tmp_path):
    options = ["--checkpoint", tmp_path / "checkpoint", "--set", "light_samples=1", "--output"]
    assert run_blender(blend_file, "-P", SCRIPT, "--", *options, "a.exr", cwd=tmp_path).returncode == 0
    move = "import bpy; bpy.data.objects['Cube'].location.x = 0.5"
    other = run_blender(blend_file, "--python-expr", move, "-P", SCRIPT, "--", *options, "b.exr", cwd=tmp_path)
    assert other.returncode == 1 and not (tmp_path / "b.exr").exists()
    assert "cannot be continued: it is of another scene" in last_line(other)


def test_memory_limit_is_an_error(blend_file, tmp_path):
    limit = ["--set", "memory_limit=1", "--output"]
    process = run_blender(
        blend_file, "--python-expr", "import bpy; bpy.context.scene.render.resolution_percentage = 800",
        "-P", SCRIPT, "--", *limit, "a.exr", cwd=tmp_path,
    )  # fmt: skip
    assert process.returncode == 1 and not (tmp_path / "a.exr").exists()
    assert "out of memory: memory_limit of 1 MiB reached" in last_line(process)
