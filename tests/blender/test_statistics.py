# SPDX-License-Identifier: GPL-3.0-or-later
"""The statistics: in a file, in the picture's header, for the panel; the numbers fit the picture."""

import json

import bpy
import numpy as np
import pytest
from helpers import add_cube, add_plane, read_exr, read_metadata, render_pixels, render_to_file
from penumbra import compat, statistics

CONTRACT = {
    "version", "build", "isa", "scene_hash", "triangles", "instances", "luminaires", "seconds", "primary_rays",
    "shadow_rays", "points_without_ray", "error_tolerance", "pixels_at_sample_limit", "error_estimate",
    "peak_memory_bytes", "warnings",
}  # fmt: skip


@pytest.fixture
def cube_scene(lit_scene):
    add_plane(lit_scene, size=5.0)
    add_cube(lit_scene, location=(0, 0, 1))
    return lit_scene


def test_the_file_has_what_the_contract_names(cube_scene, tmp_path):
    cube_scene.penumbra.statistics_file = str(tmp_path / "statistics.json")
    pixels = render_pixels(cube_scene)
    found = json.loads((tmp_path / "statistics.json").read_text(encoding="utf-8"))
    assert set(found) >= CONTRACT
    assert set(found["seconds"]) == {"export", "build", "render", "return"}
    assert set(found["error_estimate"]) == {"mean", "p99", "max"}
    assert found["primary_rays"] == 64 * 48
    assert found["triangles"] == 2 + 12 and found["instances"] == 2 and found["luminaires"] == 1
    assert found["error_tolerance"] == pytest.approx(0.004)
    assert found["light_points"] == pixels["Light Samples"].sum()
    assert found["error_estimate"]["max"] == pytest.approx(pixels["Error Estimate"].max())
    assert found["error_estimate"]["mean"] == pytest.approx(pixels["Error Estimate"].mean(), rel=1e-5)
    assert found["peak_memory_bytes"] > 50e6
    assert [path.name for path in tmp_path.iterdir()] == ["statistics.json"]  # no temporary file is left
    assert statistics.last_render == found


def test_frame_number_in_the_name_and_path_beside_the_blend_file(cube_scene, tmp_path):
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "file.blend"), check_existing=False)
    cube_scene.penumbra.statistics_file = "//s_###.json"
    cube_scene.frame_set(7)
    render_pixels(cube_scene)
    assert (tmp_path / "s_007.json").is_file()


def test_a_folder_that_is_not_there_is_an_error_before_the_render(cube_scene, tmp_path):
    cube_scene.penumbra.statistics_file = str(tmp_path / "nowhere" / "s.json")
    statistics.last_render = None
    with pytest.raises(RuntimeError, match="statistics_file: the folder .*nowhere"):
        render_pixels(cube_scene)
    assert statistics.last_render is None


@pytest.mark.parametrize("file_format", ["OPEN_EXR", "OPEN_EXR_MULTILAYER", "PNG"])
def test_the_pictures_header_has_them(cube_scene, tmp_path, file_format):
    path = tmp_path / "picture"
    render_to_file(cube_scene, "PENUMBRA", path)
    compat.set_file_format(cube_scene.render.image_settings, file_format)
    bpy.ops.render.render(write_still=True)
    header = read_metadata(path)
    found = statistics.last_render
    assert header["penumbra.version"] == found["version"]
    assert header["penumbra.shadow_rays"] == str(found["shadow_rays"])
    assert float(header["penumbra.error_estimate.p99"]) == pytest.approx(found["error_estimate"]["p99"], rel=1e-4)
    assert {name.split(".")[1] for name in header if name.startswith("penumbra.")} >= CONTRACT - {"warnings"}


def test_view_layers_add_up(cube_scene, tmp_path):
    render_pixels(cube_scene)
    alone = statistics.last_render
    cube_scene.view_layers.new("Second")
    render_to_file(cube_scene, "PENUMBRA", tmp_path / "two.exr")
    both = statistics.last_render
    assert set(both["view_layers"]) == {layer.name for layer in cube_scene.view_layers}
    for name in ("primary_rays", "shadow_rays", "triangles"):
        assert both[name] == 2 * alone[name]
    assert both["error_estimate"] == pytest.approx(alone["error_estimate"])
    assert int(read_metadata(tmp_path / "two.exr")["penumbra.primary_rays"]) == 2 * 64 * 48
    assert np.array_equal(
        *[read_exr(tmp_path / "two.exr")[f"{layer.name}.Combined"] for layer in cube_scene.view_layers]
    )


def test_the_summary_names_time_rays_and_error(cube_scene):
    render_pixels(cube_scene)
    names = dict(statistics.summary(statistics.last_render))
    assert {"Seconds", "Rays", "Estimated error", "Error tolerance"} <= set(names)
    assert f"{statistics.last_render['shadow_rays']:,} shadow" in names["Rays"]


def test_progress_tells_of_pixels_and_of_error():
    assert statistics.progress_line(0.0, 0.0) == "0 % of the pixels done"
    line = statistics.progress_line(0.25, 0.00312)
    assert line == "25 % of the pixels done, 99 % of those done with an estimated error below 0.0031"
    line = statistics.progress_line(0.25, 0.00312, 10.0)
    assert line == "25 % of the pixels done, about 30 s left, 99 % of those done with an estimated error below 0.0031"


@pytest.mark.parametrize(("done", "seconds", "text"), [
    (0.01, 100, ""), (0.5, 0.5, ""), (1.0, 10, ""), (0.5, 10, "about 10 s left"), (0.99, 2, "about 1 s left"),
    (0.1, 60, "about 9 min left"), (0.02, 1000, "about 14 h left"),
])  # fmt: skip
def test_the_time_left(done, seconds, text):
    """What is left at the same pace."""
    assert statistics.time_left(done, seconds) == text
