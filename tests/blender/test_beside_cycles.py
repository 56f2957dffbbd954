# SPDX-License-Identifier: GPL-3.0-or-later
"""Both engines' native libraries in one process: neither changes what the other renders."""

import subprocess
import sys
from pathlib import Path

import bpy
import numpy as np
import pytest
from helpers import add_area_light, add_camera, add_cube, add_plane, render_pixels, use_cycles_as_reference
from penumbra import native


def test_twenty_renders_by_turns(scene):
    """Each engine's tenth picture is its first one bit for bit, and both are lit."""
    add_plane(scene, size=10)
    add_cube(scene, location=(0.5, 0, 0.5), size=1.0)
    add_area_light(scene, location=(1, 1, 4))
    add_camera(scene, location=(0, 0, 8))
    scene.render.resolution_x, scene.render.resolution_y = 32, 24
    use_cycles_as_reference(scene, samples=4)
    first = {}
    for turn in range(20):
        engine = ("PENUMBRA", "CYCLES")[turn % 2]
        pixels = render_pixels(scene, engine)["Combined"]
        assert pixels[..., :3].mean() > 0.01
        np.testing.assert_array_equal(pixels, first.setdefault(engine, pixels))


@pytest.mark.skipif(bool(bpy.app.binary_path), reason="a Blender with a command line is always there first")
@pytest.mark.parametrize("order", [("bpy", "penumbra_native"), ("penumbra_native", "bpy")], ids=" first, then ".join)
def test_either_may_be_imported_first(order):
    """The module bpy and the native module: the self-test passes, both renderers work."""
    script = f"""
import sys
sys.path.append({str(Path(native.module.__file__).parent)!r})
import {order[0]}
import {order[1]}
penumbra_native.self_test()
bpy.context.scene.render.engine = "CYCLES"
bpy.context.scene.cycles.samples = 1
bpy.context.scene.render.resolution_percentage = 2
bpy.ops.render.render()
"""
    process = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
    assert process.returncode == 0, process.stderr
