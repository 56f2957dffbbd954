# SPDX-License-Identifier: GPL-3.0-or-later
"""The interface: presets, panels, settings in files of other versions, and what is told before the long part."""

from types import SimpleNamespace

import bpy
import pytest
from helpers import add_camera, add_cube, add_plane, emissive_material, render_pixels, run_blender, set_raw
from penumbra import notes, panels, panels_objects, presets, properties, statistics

PRESETS = ("Draft", "Good", "Final", "Paper")


def run_preset(name: str):
    bpy.ops.script.execute_preset(filepath=str(presets.FOLDER / f"{name}.py"), menu_idname="PENUMBRA_PT_presets")


def values(settings) -> dict:
    return {f"settings.{name}": getattr(settings, name) for name in presets.VALUES}


@pytest.mark.parametrize("name", PRESETS)
def test_a_preset_sets_all_that_it_names_and_renders(lit_scene, name):
    """Whatever was chosen before, and through Blender's own operator."""
    settings = lit_scene.penumbra
    for given in PRESETS:
        run_preset(given)
    settings.light_samples, settings.seed = 5, 7
    run_preset(name)
    first = values(settings)
    for other in PRESETS:
        run_preset(other)
        run_preset(name)
        assert values(settings) == first
    assert settings.seed == 7, "a seed is none of a preset's business"
    add_plane(lit_scene, size=20)
    assert render_pixels(lit_scene)["Combined"][..., 0].max() > 0.1


def test_presets_differ_as_their_names_say(scene):
    found = {}
    for name in PRESETS:
        run_preset(name)
        found[name] = values(scene.penumbra)
    tolerances = [found[name]["settings.error_tolerance"] for name in ("Draft", "Good", "Final")]
    assert tolerances == sorted(tolerances, reverse=True) and len(set(tolerances)) == 3
    defaults = {name: scene.penumbra.bl_rna.properties[name.split(".")[1]].default for name in found["Final"]}
    assert found["Final"] == pytest.approx(defaults)
    assert found["Paper"]["settings.stop_rule"] == "PAPER"


def test_the_menu_has_the_shipped_presets(scene):
    """As Blender draws it: path_menu with the user's folders."""
    found = []

    class Layout:
        def __getattr__(self, name):
            return lambda *arguments, **named: self

        def operator(self, identifier, text="", **named):
            found.append(text)
            return SimpleNamespace()

    menu = SimpleNamespace(layout=Layout(), bl_idname="PENUMBRA_PT_presets")
    presets.PENUMBRA_PT_presets.path_menu(
        menu, [], "script.execute_preset", filter_ext=lambda ext: ext == ".py", display_name=bpy.path.display_name
    )
    assert set(PRESETS) <= set(found)


def test_an_own_preset_is_saved_and_found(blend_file, scripts):
    """In a Blender of its own, as it goes to the user's folder."""
    _, environment = scripts()
    script = blend_file.parent / "own.py"
    script.write_text("""
import bpy
bpy.context.scene.penumbra.error_tolerance = 0.0625
bpy.ops.render.penumbra_preset_add(name="Mine")
bpy.context.scene.penumbra.error_tolerance = 0.5
path = bpy.utils.preset_find("Mine", "penumbra")
bpy.ops.script.execute_preset(filepath=path, menu_idname="PENUMBRA_PT_presets")
print("OWN", bpy.context.scene.penumbra.error_tolerance)
""")
    process = run_blender("--addons", "penumbra", blend_file, "--python-exit-code", "1", "-P", script,
                          environment=environment)  # fmt: skip
    assert process.returncode == 0, process.stdout + process.stderr
    assert "OWN 0.0625" in process.stdout


def test_numbers_in_files_keep_their_meaning():
    """The numbers of version 0.1.0, under which choices are saved."""
    numbers = {
        "stop_rule": ["BOUNDED", "FIXED", "PAPER", "VARIANCE"],
        "sampler": ["PRS", "SPRS", "SOBOL", "HALTON", "OWEN_SOBOL"],
        "sample_reuse": ["SAME", "CONTINUED", "ROTATED", "SCRAMBLED"],
        "filter_type": ["BLACKMAN_HARRIS", "BOX"],
    }
    for name, identifiers in numbers.items():
        items = properties.PenumbraSettings.bl_rna.properties[name].enum_items
        assert [items[identifier].value for identifier in identifiers] == list(range(len(identifiers)))


def test_a_choice_of_another_version_falls_back(lit_scene, tmp_path, capfd):
    add_plane(lit_scene, size=20)
    expected = render_pixels(lit_scene)["Combined"]
    lit_scene.penumbra.seed = 0
    for name in ("stop_rule", "sampler"):
        set_raw(lit_scene.penumbra, name, 77)
    assert properties.unknown_choices(lit_scene.penumbra) == ["stop_rule", "sampler"]
    assert (render_pixels(lit_scene)["Combined"] == expected).all()
    path = str(tmp_path / "later.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path, check_existing=False)
    capfd.readouterr()
    bpy.ops.wm.open_mainfile(filepath=path)
    settings = bpy.context.scene.penumbra
    assert (settings.stop_rule, settings.sampler, settings.saved_by) == ("BOUNDED", "OWEN_SOBOL", "0.1.0")
    assert "its stop_rule is none that this version knows; the default BOUNDED is used" in capfd.readouterr().out
    assert properties.unknown_choices(settings) == []


def test_every_setting_has_a_tooltip():
    for group in (properties.PenumbraSettings, properties.PenumbraViewLayerSettings):
        for name in group.__annotations__:
            assert len(group.bl_rna.properties[name].description) > 10, name


class Drawn:
    """Stands for a layout: notes which properties are drawn, of real owners."""

    def __init__(self) -> None:
        self.names, self.texts = [], []

    def __getattr__(self, name):
        return lambda *arguments, **named: self

    def prop(self, owner, name, **named):
        assert name in owner.bl_rna.properties, f"{owner} has no {name}"
        self.names.append(name)

    def label(self, text="", **named):
        self.texts.append(text)


def draw(panel, **context) -> Drawn:
    layout = Drawn()
    column = SimpleNamespace(layout=layout, column=lambda: layout)
    panel.draw(column, SimpleNamespace(**context))
    return layout


@pytest.mark.parametrize("stop_rule", ["BOUNDED", "FIXED", "PAPER", "VARIANCE"])
def test_panels_show_every_setting_there_is(scene, stop_rule):
    """All together show each setting that counts for the rule; none is shown twice."""
    scene.penumbra.stop_rule = stop_rule
    statistics_before, statistics.last_render = statistics.last_render, None
    shown = []
    for cls in panels.CLASSES:
        if cls.__name__.startswith("PENUMBRA_RENDER_PT") and cls is not panels.PENUMBRA_RENDER_PT_notes:
            shown += draw(cls, scene=scene).names
    statistics.last_render = statistics_before
    own = [name for name in shown if name in properties.PenumbraSettings.__annotations__]
    assert len(own) == len(set(own))
    without = {"FIXED": {"error_tolerance", "max_light_samples"}}.get(stop_rule, {"light_samples"})
    without |= set() if stop_rule == "PAPER" else {"check_interval"}
    without |= set() if stop_rule == "BOUNDED" else {"max_pixel_samples"}
    assert set(own) == set(properties.PenumbraSettings.__annotations__) - without - {"saved_by"}


@pytest.mark.parametrize("kind", ["POINT", "SUN", "SPOT", "AREA"])
def test_a_lights_panels_show_what_it_has(scene, kind):
    light = bpy.data.lights.new("Light", kind)
    shape = draw(panels_objects.PENUMBRA_LIGHT_PT_shape, light=light).names
    assert {"POINT": "shadow_soft_size", "SUN": "angle", "SPOT": "spot_blend", "AREA": "spread"}[kind] in shape
    assert {"color", "energy"} <= set(draw(panels_objects.PENUMBRA_LIGHT_PT_light, light=light).names)


def test_blenders_own_panels_are_shown_where_they_apply(engine):
    shown = {panel.__name__ for panel in panels.blender_panels()}
    assert {"OBJECT_PT_visibility", "DATA_PT_camera_dof", "EEVEE_MATERIAL_PT_surface", "EEVEE_WORLD_PT_surface",
            "DATA_PT_lens", "RENDER_PT_color_management"} <= shown  # fmt: skip
    for name in ("DATA_PT_light", "DATA_PT_area", "DATA_PT_spot"):  # ours stand for them
        panel = getattr(bpy.types, name, None)  # Blender 5 has no DATA_PT_area
        assert panel is None or "PENUMBRA" not in panel.COMPAT_ENGINES


def test_notes_are_wrapped_in_the_info_panel(lit_scene):
    add_plane(lit_scene, size=20)
    render_pixels(lit_scene)
    statistics.last_render["warnings"] = ["a word " * 20]
    assert panels.PENUMBRA_RENDER_PT_notes.poll(SimpleNamespace(engine="PENUMBRA"))
    lines = draw(panels.PENUMBRA_RENDER_PT_notes).texts
    assert len(lines) > 1 and " ".join(lines).split() == ["a", "word"] * 20
    info = draw(panels.PENUMBRA_RENDER_PT_info).texts
    assert "Rays" in info and "Estimated error" in info


def test_a_scene_without_any_light_is_told(scene):
    add_plane(scene, size=20)
    add_camera(scene)
    render_pixels(scene)
    (text,) = statistics.last_render["warnings"]
    assert text.startswith("scene 'Scene': nothing lights it")


def test_a_scene_with_light_of_any_kind_is_not(lit_scene):
    add_plane(lit_scene, size=20)
    render_pixels(lit_scene)
    assert statistics.last_render["warnings"] == []
    bpy.data.objects.remove(next(o for o in lit_scene.objects if o.type == "LIGHT"))
    lamp = add_cube(lit_scene, "Lamp", location=(0, 0, 3), size=0.5)
    lamp.data.materials.append(emissive_material("Glow", strength=5))
    render_pixels(lit_scene)
    assert statistics.last_render["warnings"] == []
    bpy.data.objects.remove(lamp)
    lit_scene.world = bpy.data.worlds.new("World")
    lit_scene.world.color = (0.5, 0.5, 0.5)
    render_pixels(lit_scene)
    assert statistics.last_render["warnings"] == []


def test_no_camera_is_refused_before_anything_is_exported(scene, monkeypatch):
    add_plane(scene, size=20)
    empty = bpy.data.objects.new("Nothing", None)
    scene.collection.objects.link(empty)
    scene.camera = empty
    read = []
    monkeypatch.setattr("penumbra.export.meshes.read_mesh", read.append)
    with pytest.raises(RuntimeError, match="camera 'Nothing' is no camera but an object of type EMPTY"):
        render_pixels(scene)
    assert read == []


def test_quiet_notes_are_kept_and_not_printed(capsys):
    quiet = notes.Notes(is_quiet=True)
    quiet.add("of a preview")
    assert quiet.texts == ["of a preview"] and capsys.readouterr().out == ""
