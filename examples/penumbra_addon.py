# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the Penumbra add-on available inside Blender, installed or not: to a script, or run by itself (blender -P)."""

import importlib
import sys
from pathlib import Path
from types import ModuleType

import bpy

ENGINE = "PENUMBRA"


def _registered_package() -> ModuleType | None:
    """The add-on's package, under whatever name it was enabled."""
    for engine in bpy.types.RenderEngine.__subclasses__():
        if getattr(engine, "bl_idname", None) == ENGINE and engine.is_registered:
            return sys.modules[engine.__module__.rpartition(".")[0]]
    return None


def load() -> ModuleType:
    """The add-on's package, registered: the enabled one, or else the one in ../addon.

    Raises RuntimeError with a sentence if there is none, or if its native module cannot be used.
    """
    package = _registered_package()
    if package is None:
        sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "addon"))
        try:
            package = importlib.import_module("penumbra")
        except ImportError as error:
            raise RuntimeError(f"the Penumbra add-on is neither enabled in Blender nor in ../addon: {error}") from error
        package.register()
    native = importlib.import_module(f"{package.__name__}.native")
    native.require()
    return package


if __name__ == "__main__":
    load()
