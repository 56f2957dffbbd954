# SPDX-License-Identifier: GPL-3.0-or-later
"""The report on speed against error: its figures recomputed from pictures, its failures, what it leaves behind."""

import csv
import json
import re
import sys

import bpy
import numpy as np
import OpenImageIO as oiio
import pytest
from helpers import (
    REPOSITORY,
    add_area_light,
    add_camera,
    add_cube,
    add_plane,
    last_line,
    make_lambertian,
    render_pixels,
    run_blender,
)
from penumbra import report
from penumbra.report import cycles, folder, measure, page, penumbra_runs, plan, study
from penumbra.report.changes import Changes

SCRIPT = REPOSITORY / "examples" / "render.py"
EXPOSURE = 1.0  # so that a forgotten one shows


@pytest.fixture
def small_scene(scene):
    """A cube on a floor that goes above white near the light, 48 x 36 pixels, a tolerance of 0.02."""
    add_plane(scene, size=6.0)
    add_cube(scene, size=1.0, location=(0, 0, 0.5), rotation=(0, 0, 0.4))
    add_area_light(scene, location=(0.8, 0.0, 3.0), power=150.0)
    add_camera(scene, location=(0.0, 0.0, 7.0))
    make_lambertian(scene)  # in the saved file, too
    scene.render.resolution_x, scene.render.resolution_y = 48, 36
    scene.view_settings.exposure = EXPOSURE
    scene.penumbra.error_tolerance, scene.penumbra.pixel_samples = 0.02, 1
    return scene


@pytest.fixture
def few_runs(monkeypatch):
    """Makes reports quick: one or two runs of each family, and 1 and 2 samples of Cycles."""
    monkeypatch.setattr(plan, "OWN_TOLERANCE_TIMES", (4.0, 1.0))
    monkeypatch.setattr(plan, "FIXED_COUNTS", (16, 64))
    monkeypatch.setattr(cycles, "SAMPLES", (1, 2))
    monkeypatch.setattr(study, "MOST_REPEATS", 1)


def leftovers(tmp_path) -> list[str]:
    """What is beside the blend file."""
    return sorted(path.name for path in tmp_path.iterdir() if not path.name.startswith("scene.blend"))


def save(tmp_path):
    path = tmp_path / "scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), check_existing=False)
    return path


def read_report(target) -> tuple[dict, list[dict]]:
    with open(target / page.TABLE, newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    return json.loads((target / folder.MANIFEST).read_text(encoding="utf-8")), rows


def picture_with(scene, settings: dict) -> np.ndarray:
    """(H, W, 3) radiance of an ordinary render with these settings of a report."""
    for name, value in settings.items():
        if hasattr(scene.penumbra, name):
            setattr(scene.penumbra, name, value)
    return render_pixels(scene)["Combined"][..., :3].astype(float)


def expected_figures(picture, reference, tolerance) -> dict[str, float]:
    """The figures of a row, from the words of the design: display units, largest of r, g, b, relative above white."""
    shown, true = picture * 2**EXPOSURE, reference * 2**EXPOSURE
    errors = np.sort((np.abs(shown - true).max(-1) / np.maximum(1, true.max(-1))).ravel())
    return {
        "rmse": np.sqrt((errors**2).mean()),
        "mean_absolute": errors.mean(),
        "p95": np.interp(0.95 * (errors.size - 1), np.arange(errors.size), errors),
        "p99": np.interp(0.99 * (errors.size - 1), np.arange(errors.size), errors),
        "max": errors[-1],
        "share_within_tolerance": (errors <= tolerance).sum() / errors.size,
    }


def test_the_whole_report_of_a_scene(small_scene, tmp_path):
    process = run_blender(save(tmp_path), "-P", SCRIPT, "--", "--report", "out", "--set", "seed=3", cwd=tmp_path)
    assert process.returncode == 0, process.stdout + process.stderr
    assert leftovers(tmp_path) == ["out"]
    target = tmp_path / "out"
    manifest, rows = read_report(target)
    assert sorted(path.name for path in target.iterdir()) == manifest["files"]
    check_rows(rows)
    check_figures(small_scene, manifest, rows)
    check_page(target, rows)


def check_rows(rows: list[dict]) -> None:
    """Counts and shares fit each other; every rule is there, Cycles too, and the user's own settings once."""
    assert {row["family"].partition(",")[0] for row in rows} == {"BOUNDED", "FIXED", "PAPER", "VARIANCE", "Cycles"}
    assert {row["sampler"] for row in rows} == {"OWEN_SOBOL", "SOBOL", "HALTON", "SPRS", "PRS", ""}
    (own,) = (row for row in rows if row["own_settings"] == "True")
    assert own["stop_rule"] == "BOUNDED" and float(own["tolerance"]) == pytest.approx(0.02)
    for row in rows:
        rmse, mean, p95, p99, largest, share = (
            float(row[name]) for name in ("rmse", "mean_absolute", "p95", "p99", "max", "share_within_tolerance")
        )
        tolerance = float(row["tolerance"])
        assert 0 <= mean <= rmse <= largest and p95 <= p99 <= largest
        assert (share >= 0.99 - 1 / (48 * 36)) == (p99 <= tolerance) or share == pytest.approx(0.99, abs=2 / (48 * 36))
        assert 0 < float(row["seconds"]) < 60 and float(row["cpu_seconds"]) > 0
        if row["renderer"] == "Cycles":
            assert row["rays"] == ""
            continue
        assert int(row["rays"]) == sum(int(row[name]) for name in ("primary_rays", "mirror_rays", "shadow_rays"))
        if row["stop_rule"] == "FIXED":  # the floor and the cube fill the frame
            assert int(row["primary_rays"]) == 48 * 36
            assert int(row["light_points"]) <= 48 * 36 * int(row["light_samples"])
            assert int(row["shadow_rays"]) + int(row["points_without_ray"]) >= int(row["light_points"])
    bounded = [float(row["rmse"]) for row in rows if row["family"].startswith("BOUNDED")]
    assert bounded == sorted(bounded, reverse=True) and len(bounded) == len(plan.OWN_TOLERANCE_TIMES)
    samples = [float(row["rmse"]) for row in rows if row["renderer"] == "Cycles"]
    assert samples == sorted(samples, reverse=True) and samples[0] > 3 * samples[-1]


def check_figures(scene, manifest: dict, rows: list[dict]) -> None:
    """Three rows, of three rules, recomputed from ordinary renders; so is the reference's own error."""
    pair = [picture_with(scene, settings) for settings in manifest["reference"]["settings"]]
    reference = (pair[0] + pair[1]) / 2
    assert (reference.max(-1) * 2**EXPOSURE > 1).mean() > 0.01  # some of it is above white
    own_error = expected_figures(pair[0], pair[1], 1.0)["p99"] / 2
    assert manifest["reference"]["error_p99"] == pytest.approx(own_error, rel=0.02)
    assert 10 * own_error <= 1.02 * min(float(row["tolerance"]) for row in rows)
    for family, setting in (
        ("BOUNDED, OWEN_SOBOL", "tolerance 0.02"),
        ("FIXED, SPRS", "64 points"),
        ("PAPER, HALTON", "tolerance 0.04"),
    ):
        (row,) = (row for row in rows if (row["family"], row["setting"]) == (family, setting))
        settings = {name: row[name] for name in ("stop_rule", "sampler", "sample_reuse")}
        settings |= {name: int(row[name]) for name in ("light_samples", "pixel_samples", "seed")}
        assert settings["seed"] == 3
        settings["error_tolerance"] = float(row["error_tolerance"])
        expected = expected_figures(picture_with(scene, settings), reference, float(row["tolerance"]))
        for name, value in expected.items():
            assert float(row[name]) == pytest.approx(value, rel=1e-6, abs=1e-12), (family, name)


def check_page(target, rows: list[dict]) -> None:
    """The page needs no other file and names every family; every PNG can be read."""
    text = (target / page.NAME).read_text(encoding="utf-8")
    sources = re.findall(r'(?:src|href)="([^"]{0,22})', text)
    assert len(sources) >= 5 and all(source == "data:image/png;base64," for source in sources)
    for row in rows:
        assert row["family"] in text and f"<td>{row['setting']}</td>" in text
    pictures = sorted(target.glob("*.png"))
    assert {"error_bounded.png", "samples_bounded.png", page.PLOT, page.REFERENCE} <= {p.name for p in pictures}
    for path in pictures:
        pixels = oiio.ImageBuf(str(path)).get_pixels(oiio.FLOAT)
        assert pixels.std() > 0.01, path


def test_no_camera_leaves_nothing(small_scene, tmp_path):
    small_scene.camera = None
    process = run_blender(save(tmp_path), "-P", SCRIPT, "--", "--report", "out", cwd=tmp_path)
    assert process.returncode != 0
    assert last_line(process).startswith("render.py: ") and "camera" in last_line(process)
    assert leftovers(tmp_path) == []


@pytest.mark.parametrize(
    ("options", "text"),
    [
        (["--report", "nowhere/out"], "nowhere does not exist"),
        (["--report", "."], "neither empty nor a former report"),
        (["--report", "out", "--output", "x.exr"], "leave --output out"),
        (["--report", "out", "--set", "sampler=SPRS"], "SPRS"),
    ],
)
def test_bad_options_end_in_one_line(small_scene, tmp_path, options, text):
    process = run_blender(save(tmp_path), "-P", SCRIPT, "--", *options, cwd=tmp_path)
    assert process.returncode != 0
    assert last_line(process).startswith("render.py: ") and text in last_line(process)
    assert leftovers(tmp_path) == []


def values_of(*owners) -> list[tuple[str, object]]:
    """Every plain setting of these owners."""
    return [
        (f"{owner.rna_type.identifier}.{entry.identifier}", str(getattr(owner, entry.identifier)))
        for owner in owners
        for entry in owner.bl_rna.properties
        if entry.type in ("BOOLEAN", "INT", "FLOAT", "STRING", "ENUM") and not getattr(entry, "is_array", False)
    ]


@pytest.mark.parametrize("fails_in", ["nothing", "page", "cycles"])
def test_every_setting_is_what_it_was(small_scene, tmp_path, few_runs, monkeypatch, fails_in):
    render = small_scene.render
    small_scene.world = bpy.data.worlds.new("World")
    render.image_settings.file_format, render.image_settings.color_mode = "JPEG", "BW"
    render.use_border, render.border_max_x = True, 0.6
    render.resolution_percentage = 150
    render.engine = "CYCLES"
    small_scene.view_layers.new("Second")
    small_scene.cycles.max_bounces, small_scene.cycles.use_denoising = 7, bpy.app.version >= (4, 0, 0)
    small_scene.camera.data.dof.use_dof = True
    owners = [
        small_scene, render, render.image_settings, small_scene.cycles, small_scene.penumbra,
        small_scene.camera.data.dof, *small_scene.view_layers, *small_scene.objects,
        *(owner.cycles for owner in small_scene.objects), getattr(small_scene.world, "cycles_visibility", render),
    ]  # fmt: skip
    before = values_of(*owners)

    def fail(*_):
        raise RuntimeError("on purpose")

    if fails_in == "nothing":
        report.write_report(small_scene, small_scene.view_layers[0], tmp_path / "out", 300)
        manifest, _ = read_report(tmp_path / "out")
        width, height = manifest["settings"]["region"][2:]
        assert 200 < width * height <= 300
        assert any("depth of field" in note for note in manifest["notes"])
    else:
        monkeypatch.setattr(*{"page": (page, "write_csv"), "cycles": (cycles, "last_picture")}[fails_in], fail)
        with pytest.raises(RuntimeError, match="on purpose"):
            report.write_report(small_scene, small_scene.view_layers[0], tmp_path / "out", 300)
    assert leftovers(tmp_path) == (["out"] if fails_in == "nothing" else [])
    assert values_of(*owners) == before
    assert not any(engine.__name__ == "Engine" and engine.is_registered
                   for engine in bpy.types.RenderEngine.__subclasses__())  # fmt: skip
    assert not any(image.name.startswith("picture") for image in bpy.data.images)


def test_only_a_former_report_is_replaced(small_scene, tmp_path, few_runs, monkeypatch):
    monkeypatch.setattr(cycles, "is_enabled", lambda scene: False)
    target, layer = tmp_path / "out", small_scene.view_layers[0]
    target.mkdir()
    report.write_report(small_scene, layer, target, 100)
    (target / page.NAME).write_text("older")
    small_scene.penumbra.pixel_samples = 4
    report.write_report(small_scene, layer, target, 100)
    manifest, rows = read_report(target)
    assert "older" not in (target / page.NAME).read_text(encoding="utf-8")[:10]
    assert {int(row["pixel_samples"]) for row in rows if row["stop_rule"] == "BOUNDED"} == {4}
    assert {int(row["pixel_samples"]) for row in rows if row["stop_rule"] == "FIXED"} == {4, 16}
    assert manifest["reference"]["settings"][0]["pixel_samples"] > 4
    assert "Cycles" not in {row["renderer"] for row in rows}
    (target / "mine.txt").write_text("precious")
    monkeypatch.setattr(penumbra_runs, "study", None)  # nothing is rendered before the folder is refused
    with pytest.raises(OSError, match="neither empty nor a former report"):
        report.write_report(small_scene, layer, target, 100)
    assert (target / "mine.txt").read_text() == "precious" and leftovers(tmp_path) == ["out"]


def test_settings_outside_the_plan_get_a_row_of_their_own(small_scene):
    own = {name: getattr(small_scene.penumbra, name) for name in plan.SETTINGS_OF_A_RUN}
    own |= {"max_light_samples": 8192, "check_interval": 5}
    for changes, rows in (({}, 0), ({"light_samples": 99}, 0), ({"stop_rule": "FIXED", "light_samples": 99}, 1)):
        planned = plan.runs(own | changes, plan.tolerances(own["error_tolerance"]))
        assert sum(run.is_own for run in planned) == 1
        assert sum(run.setting == "99 points" for run in planned) == rows
    assert not any(run.settings["stop_rule"] == "PAPER" for run in plan.runs(own | {"max_light_samples": 9}, [0.1]))


def test_seconds_for_an_error():
    rows = [{"p99": 0.1, "seconds": 1.0}, {"p99": 0.001, "seconds": 100.0}]
    assert measure.seconds_for_error(rows, 0.01) == pytest.approx(10.0)
    assert measure.seconds_for_error(rows, 0.0001) == float("inf")
    assert measure.seconds_for_error(rows, 0.2) is None


def test_changes_are_undone_in_order(scene):
    image = scene.render.image_settings
    image.file_format, image.color_depth = "PNG", "16"
    with pytest.raises(ZeroDivisionError), Changes() as changes:
        changes.keep(image, "file_format", "color_depth", "there_is_no_such_setting")
        image.file_format, image.color_depth = "OPEN_EXR", "32"
        raise ZeroDivisionError
    assert (image.file_format, image.color_depth) == ("PNG", "16")


def test_without_matplotlib_nothing_is_rendered(small_scene, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    monkeypatch.setattr(penumbra_runs, "study", None)
    with pytest.raises(RuntimeError, match="python3-matplotlib"):
        report.write_report(small_scene, small_scene.view_layers[0], tmp_path / "out")
    assert leftovers(tmp_path) == []


def test_the_addon_does_not_import_matplotlib():
    code = f"import sys; sys.path.insert(0, {str(REPOSITORY / 'addon')!r}); import penumbra; penumbra.register();" \
           "assert 'matplotlib' not in sys.modules; print('fine')"  # fmt: skip
    assert "fine" in run_blender("--python-expr", code).stdout


def test_the_operator(small_scene, tmp_path, few_runs, monkeypatch):
    monkeypatch.setattr(cycles, "is_enabled", lambda scene: False)
    assert bpy.ops.penumbra.report(filepath=str(tmp_path / "out"), pixels=100) == {"FINISHED"}
    assert (tmp_path / "out" / page.NAME).is_file()
    with pytest.raises(RuntimeError, match="nowhere does not exist"):
        bpy.ops.penumbra.report(filepath=str(tmp_path / "nowhere" / "out"))
    with pytest.raises(RuntimeError, match="no folder was given"):
        bpy.ops.penumbra.report()
