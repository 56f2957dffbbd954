# SPDX-License-Identifier: GPL-3.0-or-later
"""examples/paper: the numbers that the experiments must show, at the quick size, and the whole way to a report."""

import importlib
import re
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from helpers import REPOSITORY

pytestmark = pytest.mark.slow  # numbers of the paper, the same in any Blender

MODULES = ("engine", "methods", "metrics", "references", "scenes", "sizes", "tables", "measure.bound",
           "measure.matched_rays", "measure.picture_error", "measure.points", "measure.stride")  # fmt: skip


@pytest.fixture(scope="module")
def paper(engine):
    """The modules of examples/paper, once the add-on is registered."""
    folders = [str(REPOSITORY / "examples" / "paper"), str(REPOSITORY / "examples")]
    sys.path[:0] = folders
    yield SimpleNamespace(**{name.rpartition(".")[2]: importlib.import_module(name) for name in MODULES})
    for folder in folders:
        sys.path.remove(folder)


@pytest.fixture(scope="module")
def cases(paper):
    """Fig. 7's two scenes: name -> (exported scene, reference)."""
    return {name: (exported, reference) for name, exported, reference in paper.picture_error.cases(paper.sizes.QUICK)}


@pytest.fixture(scope="module")
def four_objects(paper):
    """Fig. 8's scene: (exported scene, reference)."""
    scene = paper.scenes.four_objects(paper.sizes.QUICK.bound_picture)
    return paper.engine.ExportedScene(scene), paper.references.converged(scene, 4096)


@pytest.fixture
def errors(paper, cases):
    """A function (scene, method, counts) -> errors in one column."""

    def measured(scene: str, method, counts, column="rmse") -> list[float]:
        return [row[column] for row in paper.picture_error.errors(scene, *cases[scene], counts, [method])]

    return measured


def test_the_closed_form_agrees_with_a_converged_picture(paper, cases):
    exported, reference = cases["unoccluded"]
    picture = exported.render(stop_rule="FIXED", light_samples=4096, **paper.methods.OWEN_SOBOL.settings)
    np.testing.assert_allclose(picture.display, reference.display, rtol=1e-4)


def test_the_converged_reference_knows_its_error(paper, cases):
    exported, reference = cases["occluded"]
    assert 0 < reference.own_error < 2e-4
    penumbra = reference.classes == paper.references.PENUMBRA
    fresh = exported.render(stop_rule="FIXED", light_samples=16384, seed=5, **paper.methods.OWEN_SOBOL.settings)
    assert paper.metrics.rmse(fresh.display[penumbra], reference.display[penumbra]) < 3 * reference.own_error


def test_prs_over_halton_at_81_points(paper, errors):
    """The paper read "almost 3" off 8-bit pixels against a PRS reference; the exact ratio is higher."""
    (prs,), (halton,) = (errors("unoccluded", method, [81]) for method in (paper.methods.PRS, paper.methods.HALTON))
    assert 3.2 < prs / halton < 4.8


@pytest.mark.parametrize(("scene", "least"), [("unoccluded", 25), ("occluded", 4.5)])
def test_prs_over_owen_sobol_at_64_points(paper, errors, scene, least):
    (prs,), (owen,) = (errors(scene, method, [64]) for method in (paper.methods.PRS, paper.methods.OWEN_SOBOL))
    assert prs / owen > least


@pytest.mark.parametrize(("sampler", "low", "high"), [("PRS", -0.53, -0.45), ("OWEN_SOBOL", -0.80, -0.70)])
def test_slopes_in_the_penumbra(paper, errors, sampler, low, high):
    method = {"PRS": paper.methods.PRS, "OWEN_SOBOL": paper.methods.OWEN_SOBOL}[sampler]
    counts = [16, 64, 256, 1024]
    assert low < paper.metrics.slope(counts, errors("occluded", method, counts, "penumbra_relative_rmse")) < high


@pytest.mark.parametrize("qmc", [("SOBOL", "SAME"), ("SOBOL", "ROTATED"), ("OWEN_SOBOL", "SCRAMBLED")])
def test_qmc_ebls_against_mc_fs(paper, four_objects, qmc):
    exported, reference = four_objects
    ways = {name: picture for name, _, picture in paper.matched_rays.four_ways(exported, paper.methods.Method(*qmc))}
    assert ways["QMC-FS"].rays >= ways["QMC-EBLS"].rays and ways["MC-FS"].rays >= ways["MC-EBLS"].rays
    rmse = {name: paper.metrics.rmse(picture.display, reference.display) for name, picture in ways.items()}
    assert rmse["QMC-EBLS"] < 0.55 * rmse["MC-FS"]


@pytest.mark.parametrize("number", range(4))
def test_the_papers_rule_misses_its_eps(paper, four_objects, number):
    method = paper.bound.METHODS[number]
    row = paper.bound.judge_rule(*four_objects, "PAPER", [0.004])[number]
    assert (row["sampler"], row["reuse"]) == method and row["beyond"] > 0.15
    assert row["beyond_penumbra"] > row["beyond_lit"]


def test_a_stride_of_two_halves_the_square_and_spoils_the_picture(paper, tmp_path):
    points = paper.engine.pn.sample_points("SOBOL", 64)
    assert (points[::2, 0] >= 0.5).all() and (points[1::2, 0] < 0.5).all()
    data = paper.tables.Data(tmp_path)
    paper.stride.measure(data, paper.sizes.QUICK)
    rows = {row["picture"]: row for row in data.read("stride_errors")}
    assert rows["careful"]["rmse_against_engine"] < 1e-3
    assert rows["striding"]["rmse"] > 3 * rows["careful"]["rmse"]


def test_from_scenes_to_a_report(paper, tmp_path):
    """All experiments, figures and chapters at a tiny size: every figure and number that the report names is there."""
    pytest.importorskip("matplotlib")
    pytest.importorskip("markdown")
    tiny = paper.sizes.QUICK._replace(
        picture=(48, 36), reference_points=1024, slope_points=(256,), most_running_points=32, running_places=2,
        starts=(0,), ray_budget=5e4, bound_picture=(64, 48), timing_rounds=1,
    )  # fmt: skip
    reproduce = importlib.import_module("reproduce")
    data = paper.tables.Data(tmp_path / "data")
    reproduce.measure(data, tiny, reproduce.EXPERIMENTS, {"size": "tiny", "seconds": {}})
    reproduce.tell(data, tmp_path)
    text = (tmp_path / "report.md").read_text()
    named = set(re.findall(r"\((figures/\w+\.png)\)", text))
    assert len(named) >= 15 and named == {f"figures/{path.name}" for path in (tmp_path / "figures").glob("*.png")}
    assert not re.search(r"\bnan\b|\binf\b", text)
    assert "What we found" in text and "<table>" in (tmp_path / "report.html").read_text()
