# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs pytest inside a real Blender; Blender's exit code is pytest's.

    blender -b --factory-startup --python-exit-code 1 -P tests/blender/run_in_blender.py -- [pytest arguments]
    python tests/blender/run_in_blender.py -- [pytest arguments]      with Blender as the module bpy

Without arguments the whole folder is run.
"""

import os
import sys
from pathlib import Path

FOLDER = Path(__file__).resolve().parent
sys.dont_write_bytecode = True
sys.path.insert(0, str(FOLDER.parents[1] / "addon"))


def add_packages_of_bpy() -> None:
    """Lets Python find what the module bpy brings for itself, such as OpenImageIO. Inside a Blender that is done."""
    import bpy

    if not bpy.app.binary_path:
        for folder in Path(bpy.utils.resource_path("LOCAL")).glob("python/lib/python*/site-packages"):
            sys.path.append(str(folder))


def main() -> int:
    add_packages_of_bpy()
    try:
        import pytest
    except ImportError:
        print(
            "run_in_blender.py: Blender's Python has no pytest (Debian: apt-get install python3-pytest)",
            file=sys.stderr,
        )
        return 1
    arguments = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else []
    paths = [] if any(os.path.exists(argument.split("::")[0]) for argument in arguments) else [str(FOLDER)]
    return int(pytest.main(["-p", "no:cacheprovider", "--rootdir", str(FOLDER), *arguments, *paths]))


code = main()
sys.stdout.flush()
sys.stderr.flush()
sys.exit(code)
