# SPDX-License-Identifier: GPL-3.0-or-later
"""Fixtures for the tests inside Blender. The functions behind them are in helpers.py (`from helpers import ...`)."""

import shutil
import sys
from pathlib import Path

import bpy
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "addon"))

import penumbra  # noqa: E402  (found through the line above)
from helpers import add_area_light, add_camera, add_plane  # noqa: E402
from recording import record  # noqa: E402


@pytest.fixture(scope="session", autouse=True)
def engine():
    """The engine, registered once for the whole run; yields its id."""
    penumbra.register()
    yield "PENUMBRA"
    penumbra.unregister()


@pytest.fixture
def scene(engine):
    """A clean scene: no objects or world, Penumbra, 64 x 48 pixels, one ray through each pixel's centre as most oracles
    want it, all passes on, exposure 0, view Standard.
    """
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    clean = bpy.context.scene
    clean.world = None
    clean.render.engine = engine
    clean.penumbra.pixel_samples = 1
    clean.render.resolution_x, clean.render.resolution_y, clean.render.resolution_percentage = 64, 48, 100
    clean.view_settings.view_transform = "Standard"
    clean.view_settings.exposure = 0.0
    layer = clean.view_layers[0]
    layer.use_pass_z = layer.use_pass_normal = layer.use_pass_position = True
    return clean


@pytest.fixture
def lit_scene(scene):
    """The clean scene with a square area light 4 m above the origin and a camera 10 m above it, looking down."""
    add_area_light(scene, location=(0.5, 0.0, 4.0))
    add_camera(scene, location=(0.0, 0.0, 10.0))
    return scene


@pytest.fixture
def recorded(lit_scene, monkeypatch):
    """A function that renders the lit scene and returns a recording of what was exported (see recording.py)."""
    return lambda: record(lit_scene, monkeypatch)


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
        shutil.copytree(Path(penumbra.__file__).parent, target, ignore=ignored)
        return target, {"BLENDER_USER_SCRIPTS": str(tmp_path / "scripts")}

    return copy
