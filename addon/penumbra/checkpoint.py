# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a render keeps its finished buckets, so that it can go on after a crash or a kill."""

from pathlib import Path

import bpy


def folder(scene, view_layer) -> str:
    """The folder of one frame and view layer below `scene.penumbra.checkpoint_folder`; "" if that is empty.

    scene: evaluated. The view layer goes by its number: its name may not be one that a file system takes.
    """
    text = scene.penumbra.checkpoint_folder
    if not text:
        return ""
    number = scene.original.view_layers.find(view_layer.name)
    return str(Path(bpy.path.abspath(text)) / f"frame_{scene.frame_current:04d}" / f"layer_{number}")
