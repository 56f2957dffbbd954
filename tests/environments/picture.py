# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders the example scene, as Debian 12's Blender saved it, in whatever Blender this is:

    blender -b --factory-startup --python-exit-code 1 -P tests/environments/picture.py -- FOLDER
    python tests/environments/picture.py -- FOLDER      with the module bpy

FOLDER gets picture.exr, picture.png and about.json, what compare.py says of it.
"""

import json
import runpy
import sys
from pathlib import Path

import bpy

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


def main(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    sys.path.insert(0, str(EXAMPLES))
    import penumbra_addon

    native = penumbra_addon.load().native.module  # before the file, whose settings are its engine's
    bpy.ops.wm.open_mainfile(filepath=str(EXAMPLES / "four_objects.blend"))
    files = ["--output", str(folder / "picture.exr"), "--view", str(folder / "picture.png")]
    sys.argv = ["render.py", "--", *files]
    runpy.run_path(str(EXAMPLES / "render.py"), run_name="__main__")
    about = {"Blender": bpy.app.version_string, "Python": sys.version.split()[0], "Embree": native.embree}
    (folder / "about.json").write_text(json.dumps(about), encoding="utf-8")


main(Path(sys.argv[sys.argv.index("--") + 1]))
