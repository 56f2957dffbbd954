# SPDX-License-Identifier: GPL-3.0-or-later
"""Penumbra: direct light with soft shadows inside Blender, rendered to an error that the user sets.

The add-on is thin: it turns Blender's evaluated scene into arrays (export/), hands them to the native renderer
(native.py) and writes the finished buckets into Blender's render result (engine.py).
"""

from . import engine, panels, presets, properties
from .report import operator

bl_info = {
    "name": "Penumbra",
    "description": "Render engine: direct light from area lights, soft shadows to a set error",
    "author": "The Penumbra authors",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "Render properties > Render engine > Penumbra",
    "category": "Render",
}


def register() -> None:
    """Called by Blender when the add-on is enabled. A missing native module does not make it fail (see native.py)."""
    properties.register()
    engine.register()
    operator.register()
    presets.register()
    panels.register()


def unregister() -> None:
    """Takes everything away that register() added."""
    panels.unregister()
    presets.unregister()
    operator.unregister()
    engine.unregister()
    properties.unregister()
