# SPDX-License-Identifier: GPL-3.0-or-later
"""Fig. 8 and 9: four objects with fixed sampling (FS) and error-bounded sampling (EBLS), rays matched as in the paper.

(d) QMC-EBLS is rendered first; (c) QMC-FS gets the smallest fixed number with at least (d)'s rays; (b) MC-EBLS uses
(d)'s stop rule; (a) MC-FS gets the smallest fixed number with at least (b)'s rays. The paper names neither its size
nor how pixels share the sequence: the size follows from the rays, and three kinds of QMC are run.
"""

import metrics
import numpy as np
import references
import scenes
from engine import ExportedScene, Picture, render_in_blender
from methods import OWEN_SOBOL, PRS, SOBOL, Method
from references import Reference
from sizes import Size
from tables import Data, Row

PAPER_RULE = {"stop_rule": "PAPER", "check_interval": 5, "error_tolerance": 0.004}
PASSES = ("Combined", "Light Samples")
ROTATED_SOBOL = Method("SOBOL", "ROTATED")
DARK_SPECK = 0.1
"""So much too dark, white being 1, makes a penumbra pixel a dark speck."""
TIMED_FIXED, TIMED_TOLERANCES = (2, 4, 8, 16, 32), (0.016, 0.008, 0.004, 0.002)


def measure(data: Data, size: Size) -> None:
    scene = scenes.four_objects(picture_for(size.ray_budget))
    exported = ExportedScene(scene)
    reference = references.converged(scene, max(size.reference_points // 4, 4096))
    rows, pictures = [], {}
    for method in (SOBOL, ROTATED_SOBOL, OWEN_SOBOL):
        for name, settings, picture in four_ways(exported, method):
            rows.append({"qmc": method.label, "method": name, **settings} | judge(picture, reference))
            if method == SOBOL:
                pictures |= {name: picture.display, f"{name} points": picture.passes["Light Samples"][..., 0]}
    own = exported.render(PASSES, stop_rule="BOUNDED", error_tolerance=0.004)
    rows.append({"qmc": OWEN_SOBOL.label, "method": "BOUNDED", "fixed_points": 0} | judge(own, reference))
    data.write("fig9_errors", rows)
    pictures |= {"reference": reference.display, "classes": reference.classes, "floor": reference.half_seen_floor}
    data.write_pictures("fig9", **pictures)
    scene.penumbra.stop_rule, scene.penumbra.error_tolerance, scene.penumbra.check_interval = "PAPER", 0.004, 5
    scene.penumbra.sampler, scene.penumbra.sample_reuse = SOBOL
    data.write_pictures("fig8", whole=render_in_blender(scene))
    data.write("fig8_through_blender", [{"largest_difference": float(
        np.max(np.abs(data.read_pictures("fig8")["whole"] - np.float32(pictures["QMC-EBLS"]))))}])  # fmt: skip
    data.write("time_and_rays", times(exported, size))


def picture_for(budget: float) -> tuple[int, int]:
    """(width, height) in the proportion 4 to 3 for which QMC-EBLS takes about so many rays."""
    trial = ExportedScene(scenes.four_objects((160, 120))).render(**PAPER_RULE, **SOBOL.settings)
    height = round(np.sqrt(budget / trial.rays) * 120)
    return round(height * 4 / 3), height


def four_ways(exported: ExportedScene, qmc: Method):
    """(name, {"fixed_points": N or 0}, picture) of (a) to (d), the pictures with their sample counts."""
    bounded = exported.render(PASSES, **PAPER_RULE, **qmc.settings)
    bounded_mc = exported.render(PASSES, **PAPER_RULE, **PRS.settings)
    yield "MC-FS", *smallest_fixed(exported, PRS, bounded_mc.rays)
    yield "MC-EBLS", {"fixed_points": 0}, bounded_mc
    yield "QMC-FS", *smallest_fixed(exported, qmc, bounded.rays)
    yield "QMC-EBLS", {"fixed_points": 0}, bounded


def smallest_fixed(exported: ExportedScene, method: Method, rays: int) -> tuple[Row, Picture]:
    """The fixed number of points with at least so many rays, and its picture."""
    low, high = 1, 2
    while exported.render(stop_rule="FIXED", light_samples=high, **method.settings).rays < rays:
        low, high = high, 2 * high
    while high - low > 1:
        middle = (low + high) // 2
        enough = exported.render(stop_rule="FIXED", light_samples=middle, **method.settings).rays >= rays
        low, high = (low, middle) if enough else (middle, high)
    return {"fixed_points": high}, exported.render(PASSES, stop_rule="FIXED", light_samples=high, **method.settings)


def judge(picture: Picture, reference: Reference) -> Row:
    penumbra = reference.classes == references.PENUMBRA
    return {
        "rays": picture.rays, "light_rays": picture.light_rays, "seconds": picture.seconds,
        "rmse": metrics.rmse(picture.display, reference.display),
        "rmse_penumbra": metrics.rmse(picture.display[penumbra], reference.display[penumbra]),
        "dark_specks": float(np.mean(np.min(picture.display - reference.display, axis=-1)[penumbra] < -DARK_SPECK)),
        "over_tolerance": float(np.mean(metrics.largest_channel_error(picture.display, reference.display) > 0.004)),
        "points_lit": mean_points(picture, reference, references.LIT),
        "points_penumbra": mean_points(picture, reference, references.PENUMBRA),
        "reference_own_error": reference.own_error,
    }  # fmt: skip


def mean_points(picture: Picture, reference: Reference, part: int) -> float:
    return float(picture.passes["Light Samples"][..., 0][reference.classes == part].mean())


def times(exported: ExportedScene, size: Size) -> list[Row]:
    """Rays and seconds on one thread over a range of settings, the least time of several rounds."""
    runs = [({"stop_rule": "FIXED", "light_samples": n}, m) for n in TIMED_FIXED for m in (PRS, SOBOL)]
    runs += [(PAPER_RULE | {"error_tolerance": e}, m) for e in TIMED_TOLERANCES for m in (PRS, SOBOL)]
    rows = []
    for settings, method in runs:
        rounds = [exported.render(threads=1, **settings, **method.settings) for _ in range(size.timing_rounds)]
        rows.append({"rule": "FS" if settings["stop_rule"] == "FIXED" else "EBLS", "sampler": method.sampler,
                     "rays": rounds[0].rays, "traced": rounds[0].statistics["shadow_rays"],
                     "seconds": min(r.seconds for r in rounds)})  # fmt: skip
    return rows
