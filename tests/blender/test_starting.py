# SPDX-License-Identifier: GPL-3.0-or-later
"""The ways people start the engine, in a Blender of its own: installed zip, --addons, another package name; and what
happens when the native module is missing, of another Python or broken."""

import re
import shutil
import subprocess
import sys

import bpy
import numpy as np
import pytest
from helpers import REPOSITORY, add_area_light, add_camera, add_plane, animate, read_exr, run_blender

ADDON = REPOSITORY / "addon" / "penumbra"
NATIVE = next(iter(ADDON.glob("penumbra_native*")))


@pytest.fixture
def blend_file(scene, tmp_path):
    """A saved scene whose engine is Penumbra: 64 x 48 pixels, a lit plane."""
    add_plane(scene, size=20)
    add_area_light(scene, location=(0, 0, 3))
    add_camera(scene)
    path = tmp_path / "scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), check_existing=False)
    return path


@pytest.fixture
def scripts(tmp_path):
    """A function that copies the add-on into a scripts folder under a name: (the copy, environment for run_blender)."""

    def copy(name="penumbra", with_native=True):
        target = tmp_path / "scripts" / "addons" / name
        ignored = shutil.ignore_patterns("__pycache__", *([] if with_native else ["penumbra_native*"]))
        shutil.copytree(ADDON, target, ignore=ignored)
        return target, {"BLENDER_USER_SCRIPTS": str(tmp_path / "scripts")}

    return copy


def command_line(name, blend_file):
    output = blend_file.parent / "out_"
    return ["--addons", name, blend_file, "-E", "PENUMBRA", "-o", output, "-F", "OPEN_EXR", "-f", "1"]


@pytest.mark.parametrize("name", ["penumbra", "soft_shadows_2"])
def test_command_line_under_any_package_name(blend_file, scripts, name):
    _, environment = scripts(name)
    process = run_blender(*command_line(name, blend_file), environment=environment)
    assert process.returncode == 0, process.stdout + process.stderr
    pixels = read_exr(blend_file.parent / "out_0001.exr")["Combined"]
    assert pixels.shape == (48, 64, 4) and pixels[..., :3].min() > 0


def test_words_that_farms_fail_on_stay_out_of_the_log(blend_file, scripts):
    _, environment = scripts()
    process = run_blender(*command_line("penumbra", blend_file), environment=environment)
    lines = (process.stdout + process.stderr).splitlines()
    ours = [line for line in lines if "system.path" not in line]  # Blender 5's own, about mounted file systems
    assert not re.search("warning|error:", "\n".join(ours), re.IGNORECASE)


def test_installing_the_zip(blend_file, tmp_path):
    archive = tmp_path / "penumbra.zip"
    subprocess.run([sys.executable, REPOSITORY / "addon" / "make_zip.py", archive], check=True, capture_output=True)
    script = tmp_path / "install.py"
    script.write_text(f"""
import bpy
bpy.ops.preferences.addon_install(filepath={str(archive)!r})
bpy.ops.preferences.addon_enable(module="penumbra")
bpy.ops.wm.open_mainfile(filepath={str(blend_file)!r})
assert bpy.context.scene.render.engine == "PENUMBRA"
bpy.context.scene.render.image_settings.file_format = "OPEN_EXR"
bpy.context.scene.render.filepath = {str(tmp_path / "out.exr")!r}
bpy.ops.render.render(write_still=True)
""")
    (tmp_path / "user").mkdir()
    process = run_blender("--python-exit-code", "1", "-P", script, environment={
        "BLENDER_USER_SCRIPTS": str(tmp_path / "user")})  # fmt: skip
    assert process.returncode == 0, process.stdout + process.stderr
    assert read_exr(tmp_path / "out.exr")["Combined"][..., :3].min() > 0


BROKEN_MODULES = {
    "missing": (None, b"", "is missing from .*: build it"),
    "another Python": (
        "penumbra_native.cpython-38-x86_64-linux-gnu.so",
        b"",
        "was built for another Python; this Blender",
    ),
    "no library": (NATIVE.name, b"no library", "cannot be loaded: .*"),
}


@pytest.mark.parametrize(("file_name", "content", "sentence"), BROKEN_MODULES.values(), ids=BROKEN_MODULES.keys())
def test_without_a_usable_native_module_enabling_works_and_rendering_says_why(
    blend_file, scripts, file_name, content, sentence
):
    folder, environment = scripts(with_native=False)
    if file_name:
        (folder / file_name).write_bytes(content)
    process = run_blender(*command_line("penumbra", blend_file), environment=environment)
    assert process.returncode == 1
    assert re.search(f"Penumbra: The native module .*{sentence}", process.stdout + process.stderr)
    assert "Traceback" not in process.stdout + process.stderr
    assert not list(blend_file.parent.glob("out_*"))


def test_a_failing_scene_exits_with_1_and_leaves_no_picture(scene, tmp_path, scripts):
    add_camera(scene, "Round", type="PANO")
    path = tmp_path / "scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), check_existing=False)
    _, environment = scripts()
    process = run_blender(*command_line("penumbra", path), environment=environment)
    assert process.returncode == 1
    assert "camera 'Round'" in process.stdout + process.stderr
    assert not list(tmp_path.glob("out_*"))


def test_an_animation_from_the_command_line(scene, tmp_path, scripts):
    add_plane(scene, size=20)
    light = add_area_light(scene, location=(0, 0, 3))
    animate(light.data, "energy", {1: 100.0, 3: 300.0})
    add_camera(scene)
    scene.penumbra.stop_rule = "FIXED"
    path = tmp_path / "scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), check_existing=False)
    _, environment = scripts()
    arguments = ["--addons", "penumbra", path, "-o", tmp_path / "f", "-F", "OPEN_EXR", "-s", "1", "-e", "3", "-a"]
    process = run_blender(*arguments, environment=environment)
    assert process.returncode == 0
    means = [read_exr(tmp_path / f"f{frame:04d}.exr")["Combined"][..., 0].mean() for frame in (1, 2, 3)]
    np.testing.assert_allclose(np.array(means) / means[0], [1, 2, 3], rtol=1e-3)
