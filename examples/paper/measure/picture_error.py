# SPDX-License-Identifier: GPL-3.0-or-later
"""Fig. 7: the error of the whole picture against the number of points, for all samplers and treatments.

Also the paper's own reference (PRS with 10^4 points), 8-bit pixels, and the slopes in the penumbra.
"""

import methods
import metrics
import numpy as np
import references
import scenes
from engine import ExportedScene
from methods import Method
from references import Reference
from sizes import Size
from tables import Data, Row

PAPER_COUNTS = tuple(n * n for n in range(2, 11))
PAPER_REFERENCE_POINTS = 10_000
MEASURED_AT = 81


def measure(data: Data, size: Size) -> None:
    rows, pixels = [], []
    for case, exported, reference in cases(size):
        rows += errors(case, exported, reference, PAPER_COUNTS + size.slope_points, methods.ALL)
        pixels += paper_ratios(case, exported, reference)
    data.write("fig7_errors", rows)
    data.write("fig7_ratios_at_81", pixels)


def cases(size: Size):
    """(name, exported scene, reference) of the two scenes."""
    scene = scenes.sphere_on_ground(size.picture, sphere=False)
    yield "unoccluded", ExportedScene(scene), references.closed_form(scene)
    scene = scenes.sphere_on_ground(size.picture)
    yield "occluded", ExportedScene(scene), references.converged(scene, size.reference_points)


def errors(case: str, exported: ExportedScene, reference: Reference, counts, chosen: list[Method]) -> list[Row]:
    """Errors in display units; on the floor's penumbra (see Reference.half_seen_floor) relative to unshadowed light."""
    half_seen = reference.half_seen_floor
    rows = []
    for method in chosen:
        for count in counts:
            picture = exported.render(stop_rule="FIXED", light_samples=count, **method.settings)
            difference = (picture.display - reference.display)[half_seen] / reference.unshadowed[half_seen]
            rows.append({
                "scene": case, "sampler": method.sampler, "reuse": method.reuse, "points": count,
                "rmse": metrics.rmse(picture.display, reference.display),
                "mean_absolute": metrics.mean_absolute(picture.display, reference.display),
                "penumbra_relative_rmse": float(np.sqrt(np.mean(difference**2))) if half_seen.any() else 0.0,
                "reference_own_error": reference.own_error, "light_rays": picture.light_rays,
            })  # fmt: skip
    return rows


def paper_ratios(case: str, exported: ExportedScene, reference: Reference) -> list[Row]:
    """Errors with 81 points by ways of measuring: which reference, which pixels, which formula."""
    stand_in = exported.render(
        stop_rule="FIXED", light_samples=PAPER_REFERENCE_POINTS, seed=1, **methods.PRS.settings
    ).display
    keep, rounded = np.asarray, metrics.eight_bit
    ways = {
        "exact, float, RMS": (reference.display, keep, metrics.rmse),
        "exact, float, mean absolute": (reference.display, keep, metrics.mean_absolute),
        "PRS 10^4, float, RMS": (stand_in, keep, metrics.rmse),
        "PRS 10^4, float, mean absolute": (stand_in, keep, metrics.mean_absolute),
        "PRS 10^4, 8 bit, RMS": (stand_in, rounded, metrics.rmse),
        "PRS 10^4, 8 bit, mean absolute": (stand_in, rounded, metrics.mean_absolute),
    }
    rows = []
    for method in methods.ALL:
        picture = exported.render(stop_rule="FIXED", light_samples=MEASURED_AT, **method.settings).display
        for way, (against, pixels, error) in ways.items():
            rows.append({"scene": case, "sampler": method.sampler, "reuse": method.reuse, "way": way,
                         "error": error(pixels(picture), pixels(against))})  # fmt: skip
    return rows
