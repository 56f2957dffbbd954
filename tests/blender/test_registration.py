# SPDX-License-Identifier: GPL-3.0-or-later
"""Enabling and disabling the add-on: everything is there, everything is gone again; the panels draw."""

import bpy
import penumbra
import pytest
from penumbra import native, panels, statistics


def engines() -> set[str]:
    return {getattr(cls, "bl_idname", "") for cls in bpy.types.RenderEngine.__subclasses__() if cls.is_registered}


def panels_of_the_engine() -> set[str]:
    return {cls.__name__ for cls in panels.blender_panels() if "PENUMBRA" in cls.COMPAT_ENGINES}


def test_unregister_takes_everything_away_and_register_brings_it_back(scene):
    before = panels_of_the_engine()
    assert len(before) > 100
    penumbra.unregister()
    try:
        assert "PENUMBRA" not in engines()
        assert panels_of_the_engine() == set()
        assert not hasattr(bpy.types.Scene, "penumbra") and not hasattr(bpy.types.ViewLayer, "penumbra")
    finally:
        penumbra.register()
    assert "PENUMBRA" in engines()
    assert panels_of_the_engine() == before


def test_panels_that_users_need_are_shown(scene):
    shown = panels_of_the_engine()
    assert {"EEVEE_MATERIAL_PT_surface", "MATERIAL_PT_preview", "RENDER_PT_format"} <= shown
    assert "DATA_PT_area" not in shown  # the panel of our own has its properties


def test_defaults_are_those_of_the_contract(scene):
    settings = bpy.data.scenes.new("fresh").penumbra
    expected = {
        "stop_rule": "BOUNDED", "sampler": "OWEN_SOBOL", "sample_reuse": "SCRAMBLED", "light_samples": 64,
        "max_light_samples": 8192, "check_interval": 5, "pixel_samples": 16, "filter_type": "BLACKMAN_HARRIS",
        "filter_width": 1.5, "mirror_depth": 4, "seed": 0, "statistics_file": "",
    }  # fmt: skip
    assert {name: getattr(settings, name) for name in expected} == expected
    assert settings.error_tolerance == pytest.approx(0.004)


class Layout:
    """Stands for Blender's layout: takes every call, checks that the properties exist, keeps the labels."""

    def __init__(self, labels=None):
        self.labels = [] if labels is None else labels

    def __getattr__(self, name):
        return lambda *arguments, **options: Layout(self.labels)

    def prop(self, owner, name, **options):
        assert name in owner.bl_rna.properties, name

    def label(self, text="", **options):
        self.labels.append(text)


class Self:
    """Stands for a panel that is being drawn."""

    def __init__(self, cls):
        self.layout = Layout()
        self.column = lambda: cls.column(self)


def kinds_of(base):
    """The panels themselves, not the classes that some of them have in common."""
    return [kind for cls in base.__subclasses__() for kind in kinds_of(cls) or [cls]]


@pytest.mark.parametrize("stop_rule", ["BOUNDED", "FIXED", "PAPER", "VARIANCE"])
def test_every_panel_draws(lit_scene, recorded, stop_rule):
    lit_scene.penumbra.stop_rule = stop_rule
    recorded()
    bpy.context.view_layer.objects.active = lit_scene.objects["Light"]
    light = lit_scene.objects["Light"]
    known = {"scene": lit_scene, "view_layer": lit_scene.view_layers[0], "engine": "PENUMBRA", "object": light}
    context = type("Context", (), {**known, "light": light.data})
    labels = []
    for cls in kinds_of(panels.PropertiesPanel):
        if not cls.poll(context):
            assert cls.__name__ == "PENUMBRA_RENDER_PT_notes"  # there is nothing to note
            continue
        panel = Self(cls)
        cls.draw(panel, context)
        labels += panel.layout.labels
    assert dict(statistics.summary(statistics.last_render))["Rays"] in labels


def test_the_reason_of_a_missing_module_is_shown(scene, monkeypatch):
    monkeypatch.setattr(native, "module", None)
    monkeypatch.setattr(native, "reason", "The native module was built for another Embree: 4.")
    panel = Self(panels.PenumbraPreferences)
    panels.PenumbraPreferences.draw(panel, None)
    assert "".join(panel.layout.labels) == native.reason
