# SPDX-License-Identifier: GPL-3.0-or-later
"""Installing as users do, each in a Blender with empty user folders, with no compiler on the PATH."""

import subprocess
import sys
import zipfile

import bpy
import pytest
from helpers import REPOSITORY, command_line, read_exr, run_blender

HAS_EXTENSIONS = bpy.app.version >= (4, 2, 0)


@pytest.fixture(scope="module")
def zips(tmp_path_factory) -> dict[str, str]:
    """The add-on's zips: "legacy" and "extension" -> path."""
    folder = tmp_path_factory.mktemp("zips")
    subprocess.run([sys.executable, REPOSITORY / "addon" / "make_zip.py", folder], check=True, capture_output=True)
    return {path.name.split("-")[2]: str(path) for path in folder.glob("penumbra-*.zip")}


@pytest.fixture
def user(tmp_path):
    """Variables of a user with an empty home and nothing but Python, which Debian's Blender looks for, on the PATH."""
    programs, home = tmp_path / "programs", tmp_path / "home"
    programs.mkdir()
    home.mkdir()
    (programs / "python3").symlink_to(sys.executable)
    return {"PATH": str(programs), "HOME": str(home), **dict.fromkeys(
        ("BLENDER_USER_RESOURCES", "BLENDER_USER_CONFIG", "BLENDER_USER_SCRIPTS"), str(home))}  # fmt: skip


def succeed(*arguments, **options) -> str:
    """What Blender printed; its exit code must be 0."""
    process = run_blender(*arguments, **options)
    assert process.returncode == 0, process.stdout + process.stderr
    return process.stdout


def assert_lit(path) -> None:
    assert read_exr(path)["Combined"][..., :3].min() > 0


def test_both_zips_hold_one_native_module_and_only_the_extension_a_manifest(zips):
    assert set(zips) == {"legacy", "extension"}
    for kind, path in zips.items():
        names = zipfile.ZipFile(path).namelist()
        assert len([name for name in names if "penumbra_native." in name]) == 1
        assert all(name.startswith("penumbra/") for name in names) == (kind == "legacy")
        assert ("blender_manifest.toml" in names) == (kind == "extension")


def test_the_legacy_zip_by_the_preferences(blend_file, zips, user, tmp_path):
    script = tmp_path / "install.py"
    script.write_text(f"""
import bpy
bpy.ops.preferences.addon_install(filepath={zips["legacy"]!r})
bpy.ops.preferences.addon_enable(module="penumbra")
bpy.ops.wm.open_mainfile(filepath={str(blend_file)!r})
assert bpy.context.scene.render.engine == "PENUMBRA"
bpy.context.scene.render.image_settings.file_format = "OPEN_EXR"
bpy.context.scene.render.filepath = {str(tmp_path / "out.exr")!r}
bpy.ops.render.render(write_still=True)
""")
    succeed("--python-exit-code", "1", "-P", script, environment=user)
    assert_lit(tmp_path / "out.exr")


@pytest.mark.skipif(not HAS_EXTENSIONS, reason="extensions came with Blender 4.2")
def test_the_extension_zip_by_the_command_line(blend_file, zips, user):
    succeed("--command", "extension", "validate", zips["extension"], environment=user)
    succeed("--command", "extension", "install-file", "--repo", "user_default", zips["extension"], environment=user)
    succeed("--offline-mode", *command_line("bl_ext.user_default.penumbra", blend_file), environment=user)
    assert_lit(blend_file.parent / "out_0001.exr")


@pytest.mark.skipif(bool(bpy.app.binary_path), reason="the other tests show it in a Blender with a command line")
def test_the_extension_zip_by_bpy(zips, user, tmp_path):
    script = tmp_path / "install.py"
    script.write_text(f"""
import bpy
bpy.ops.extensions.package_install_files(repo="user_default", filepath={zips["extension"]!r}, enable_on_install=True)
engines = {{cls.bl_idname: cls.__module__ for cls in bpy.types.RenderEngine.__subclasses__()}}
assert engines["PENUMBRA"] == "bl_ext.user_default.penumbra.engine", engines
""")
    process = subprocess.run([sys.executable, script], env=user, capture_output=True, text=True, check=False)
    assert process.returncode == 0, process.stdout + process.stderr
