# SPDX-License-Identifier: GPL-3.0-or-later
"""Fig. 4 and 5: the sphere's scene, rendered by Blender, and a crop of its penumbra with 16 points a pixel."""

import metrics
import numpy as np
import references
import scenes
from engine import ExportedScene, render_in_blender
from methods import HALTON, OWEN_SOBOL, PRS, SOBOL, SPRS, Method
from sizes import Size
from tables import Data

POINTS = 16
WHOLE_POINTS = 256
REFERENCE_POINTS = 4096
ENLARGED = 3
"""The crop is rendered at so many times the picture's resolution."""
SHOWN = [PRS, SPRS, SOBOL, HALTON, Method("SOBOL", "ROTATED"), Method("HALTON", "ROTATED"), OWEN_SOBOL]


def measure(data: Data, size: Size) -> None:
    scene = scenes.sphere_on_ground(tuple(ENLARGED * n for n in size.picture))
    settings = scene.penumbra
    settings.stop_rule, settings.light_samples = "FIXED", WHOLE_POINTS
    settings.sampler, settings.sample_reuse = OWEN_SOBOL
    whole = render_in_blender(scene)
    exported = ExportedScene(scene)
    same = exported.render(stop_rule="FIXED", light_samples=WHOLE_POINTS, **OWEN_SOBOL.settings).display
    reference = references.converged(scene, REFERENCE_POINTS)
    x, y, width, height = crop = penumbra_crop(reference)
    exact = reference.display[y : y + height, x : x + width]
    pictures, rows = {}, []
    for method in SHOWN:
        picture = exported.render(stop_rule="FIXED", light_samples=POINTS, region=crop, **method.settings).display
        pictures[method.label] = picture
        rows.append({"sampler": method.sampler, "reuse": method.reuse, "points": POINTS,
                     "rmse": metrics.rmse(picture, exact),
                     "mean_absolute": metrics.mean_absolute(picture, exact)})  # fmt: skip
    data.write_pictures("fig4", whole=whole, crop=np.array(crop))
    data.write_pictures("fig5", reference=exact, **pictures)
    data.write("fig5_errors", rows)
    data.write("fig4_through_blender", [{"largest_difference": float(np.max(np.abs(whole - same)))}])


def penumbra_crop(reference: references.Reference) -> tuple[int, int, int, int]:
    """(x, y, width, height) around the left end of the floor's penumbra, a sixth of the picture wide."""
    height, width = reference.classes.shape
    rows, columns = np.nonzero(reference.half_seen_floor)
    w, h = width // 6, height // 5
    y = int(np.median(rows[columns < columns.min() + w // 2]))
    return int(columns.min()) - w // 4, max(0, y - h // 2), w, h
