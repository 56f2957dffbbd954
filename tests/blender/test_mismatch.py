# SPDX-License-Identifier: GPL-3.0-or-later
"""A native module that does not fit this Blender: the add-on can be enabled, its preferences and each render say why in
a sentence, and Blender goes on."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest
from helpers import command_line, run_blender, run_script
from penumbra import native

MODULE = Path(native.module.__file__)
EMBREE = re.search(rb"libembree\d\.so\.\d", MODULE.read_bytes())[0]

BROKEN_MODULES = {
    "missing": (None, b"", "is missing from .*: build it"),
    "another Python": ("penumbra_native.cpython-38-x86_64-linux-gnu.so", b"", "was built for another Python; this"),
    "no library": (MODULE.name, b"no library", "cannot be loaded: .*"),
    "another Embree": (
        MODULE.name,
        MODULE.read_bytes().replace(EMBREE, EMBREE.replace(b"libembree", b"libbreeem")),
        r"needs libbreeem\d\.so\.\d, which neither this Blender nor the system has",
    ),
}


@pytest.mark.parametrize(("file_name", "content", "sentence"), BROKEN_MODULES.values(), ids=BROKEN_MODULES.keys())
def test_enabling_works_and_rendering_says_why(blend_file, scripts, file_name, content, sentence):
    folder, environment = scripts(with_native=False)
    if file_name:
        (folder / file_name).write_bytes(content)
    process = run_blender(*command_line("penumbra", blend_file), environment=environment)
    assert process.returncode == 1
    assert re.search(f"Penumbra: The native module .*{sentence}", process.stdout + process.stderr)
    assert "Traceback" not in process.stdout + process.stderr
    assert not list(blend_file.parent.glob("out_*"))


SHOW_PREFERENCES = """
import bpy
from types import SimpleNamespace
bpy.ops.preferences.addon_enable(module="penumbra")
labels = []
row = SimpleNamespace(label=lambda text, **options: labels.append(text), alert=False)
addon = bpy.context.preferences.addons["penumbra"].preferences
type(addon).draw(SimpleNamespace(layout=SimpleNamespace(box=lambda: row)), None)
print("PREFERENCES", " ".join(labels))
"""


def test_another_version_of_embree_in_the_process_is_said_in_the_preferences(scripts, tmp_path):
    """Another library that answers for Embree: its version is not the one that the module was built for."""
    if not shutil.which("gcc"):
        pytest.skip("no C compiler to make the other library with")
    source, library = tmp_path / "other.c", tmp_path / "libother.so"
    source.write_text("long rtcGetDeviceProperty(void* device, int property) { return 20100; }")
    subprocess.run(["gcc", "-shared", "-fPIC", source, "-o", library], check=True)
    script = tmp_path / "preferences.py"
    script.write_text(SHOW_PREFERENCES)
    _, environment = scripts()
    process = run_script(script, {**environment, "LD_PRELOAD": str(library)})
    assert process.returncode == 0
    assert re.search(r"PREFERENCES The native module .*built for Embree \d, but .* has Embree 2", process.stdout)
