# SPDX-License-Identifier: GPL-3.0-or-later
"""Installing as users do, each in a Blender with empty user folders, with no compiler on the PATH."""

import subprocess
import sys
import zipfile

import bpy
import pytest
from helpers import REPOSITORY, command_line, read_exr, run_blender, run_script

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
    for name in ("python3", f"python3.{sys.version_info.minor}"):  # newer Blenders look for the second
        (programs / name).symlink_to(sys.executable)
    return {"PATH": str(programs), "HOME": str(home), **dict.fromkeys(
        ("BLENDER_USER_RESOURCES", "BLENDER_USER_CONFIG", "BLENDER_USER_SCRIPTS"), str(home))}  # fmt: skip


def assert_success(process) -> None:
    assert process.returncode == 0, process.stdout + process.stderr


def assert_lit(path) -> None:
    assert read_exr(path)["Combined"][..., :3].min() > 0


def test_both_zips_hold_one_native_module_and_only_the_extension_a_manifest(zips):
    assert set(zips) == {"legacy", "extension"}
    for kind, path in zips.items():
        names = zipfile.ZipFile(path).namelist()
        assert len([name for name in names if "penumbra_native." in name]) == 1
        assert all(name.startswith("penumbra/") for name in names) == (kind == "legacy")
        assert ("blender_manifest.toml" in names) == (kind == "extension")


RENDER = """
bpy.ops.wm.open_mainfile(filepath={blend_file!r})
engines = {{getattr(cls, "bl_idname", ""): cls.__module__ for cls in bpy.types.RenderEngine.__subclasses__()}}
assert engines["PENUMBRA"] == "{addon}.engine", engines
bpy.context.scene.render.image_settings.file_format = "OPEN_EXR"
bpy.context.scene.render.filepath = {output!r}
bpy.ops.render.render(write_still=True)
"""


def install_and_render(commands: str, addon: str, blend_file, user, folder) -> None:
    """Runs a script of `commands` that install and enable the add-on, and that renders the file with it then."""
    script, output = folder / "install.py", folder / "out.exr"
    render = RENDER.format(blend_file=str(blend_file), addon=addon, output=str(output))
    script.write_text("import bpy\n" + commands + render)
    assert_success(run_script(script, user))
    assert_lit(output)


def test_the_legacy_zip_by_the_preferences(blend_file, zips, user, tmp_path):
    commands = f"""
bpy.ops.preferences.addon_install(filepath={zips["legacy"]!r})
bpy.ops.preferences.addon_enable(module="penumbra")
"""
    install_and_render(commands, "penumbra", blend_file, user, tmp_path)


@pytest.mark.skipif(not HAS_EXTENSIONS, reason="extensions came with Blender 4.2")
def test_the_extension_zip_by_the_preferences(blend_file, zips, user, tmp_path):
    commands = f"""
bpy.ops.extensions.package_install_files(repo="user_default", filepath={zips["extension"]!r}, enable_on_install=True)
"""
    install_and_render(commands, "bl_ext.user_default.penumbra", blend_file, user, tmp_path)


@pytest.mark.skipif(not HAS_EXTENSIONS, reason="extensions came with Blender 4.2")
def test_the_extension_zip_by_the_command_line(blend_file, zips, user):
    for arguments in (
        ("--command", "extension", "validate", zips["extension"]),
        ("--command", "extension", "install-file", "--repo", "user_default", zips["extension"]),
        ("--offline-mode", *command_line("bl_ext.user_default.penumbra", blend_file)),
    ):
        assert_success(run_blender(*arguments, environment=user))
    assert_lit(blend_file.parent / "out_0001.exr")
