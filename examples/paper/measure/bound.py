# SPDX-License-Identifier: GPL-3.0-or-later
"""Does the bound hold? The share of pixels whose true error exceeds the eps that was asked for, on the four objects.

And on the scene of examples/make_four_objects.py, whose luminaire seems half as wide: does the answer depend on it?
"""

import metrics
import numpy as np
import references
import scenes
from engine import ExportedScene
from methods import OWEN_SOBOL, PRS, SOBOL, Method
from references import Reference
from sizes import Size
from tables import Data, Row

TOLERANCES = (0.02, 0.01, 0.004, 0.002, 0.001)
PARTS = {"lit": references.LIT, "penumbra": references.PENUMBRA, "umbra": references.UMBRA}
PAPER_EPS = 0.004
FEWEST_POINTS = 10
"""Before which neither PAPER (t = 5) nor VARIANCE stops."""
METHODS = (PRS, SOBOL, Method("SOBOL", "ROTATED"), OWEN_SOBOL)
RULES = ("PAPER", "standard error", "variance of the mean", "BOUNDED")


def settings_of(rule: str, eps: float) -> dict:
    """Native settings. VARIANCE stops at sqrt(V / n) < eps. The paper's other rule read literally, V(L) < eps with V(L)
    the variance of the estimate, is the same test with sqrt(eps)."""
    if rule == "standard error":
        return {"stop_rule": "VARIANCE", "error_tolerance": eps}
    if rule == "variance of the mean":
        return {"stop_rule": "VARIANCE", "error_tolerance": eps**0.5}
    return {"stop_rule": rule, "error_tolerance": eps}


def measure(data: Data, size: Size) -> None:
    scene = scenes.four_objects(size.bound_picture)
    reference = references.converged(scene, size.reference_points)
    exported = ExportedScene(scene)
    data.write("bound", [row for rule in RULES for row in judge_rule(exported, reference, rule, TOLERANCES)])
    worst = exported.render(**settings_of("PAPER", PAPER_EPS), **SOBOL.settings)
    data.write_pictures("bound", picture=worst.display, reference=reference.display, classes=reference.classes)

    scene = scenes.four_objects_of_the_examples(size.bound_picture)
    reference = references.converged(scene, size.reference_points)
    data.write("bound_other_scene", judge_rule(ExportedScene(scene), reference, "PAPER", (PAPER_EPS,)))


def judge_rule(exported: ExportedScene, reference: Reference, rule: str, tolerances) -> list[Row]:
    rows = []
    for method in [OWEN_SOBOL] if rule == "BOUNDED" else METHODS:
        for eps in tolerances:
            picture = exported.render(("Combined", "Light Samples"), **settings_of(rule, eps), **method.settings)
            rows.append({"rule": rule, **method._asdict(), "eps": eps} | judge(picture, reference, eps))
    return rows


def judge(picture, reference: Reference, eps: float) -> Row:
    """Shares of pixels beyond eps, of all and of each part; of the penumbra, those beyond eps that stopped at the first
    look; rays a pixel; the 99th percentile of the error / eps."""
    error = metrics.largest_channel_error(picture.display, reference.display)
    beyond = error > eps
    early = picture.passes["Light Samples"][..., 0] <= FEWEST_POINTS
    pixels = error.size
    return {
        "beyond": float(beyond.mean()),
        **{f"beyond_{name}": float(beyond[reference.classes == part].mean()) for name, part in PARTS.items()},
        **{f"share_{name}": float(np.mean(reference.classes == part)) for name, part in PARTS.items()},
        "false_stops": float((beyond & early)[reference.classes == references.PENUMBRA].mean()),
        "p99_over_eps": float(np.quantile(error, 0.99)) / eps,
        "light_rays_per_pixel": picture.light_rays / pixels,
        "at_limit": picture.statistics["pixels_at_sample_limit"] / pixels,
        "reference_own_error": reference.own_error,
    }
