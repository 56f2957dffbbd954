# SPDX-License-Identifier: GPL-3.0-or-later
"""Chapter: Fig. 6 and 7, how fast the error falls."""

import statistics

import metrics
from measure.picture_error import MEASURED_AT
from measure.running_mean import SETTLED_WITHIN, SHOWN
from methods import ALL, NAMES
from tables import Data, markdown, one, where

from .words import figure, times

SLOPE_POINTS = (16, 64, 256, 1024, 4096)
"""Powers of four, of which the full size has all and the quick one those up to 1024."""


def tell(data: Data) -> str:
    return f"""## 3. How fast the error falls

### One point of the floor

{figure("fig6")}
Repeated, as the paper says it did, with other luminaires of equal area and other starting indices. From how many
points on does the running mean stay within {100 * SETTLED_WITHIN:g} % of the unshadowed radiance? The median over
floor points (a ">" where most had not settled by the end):

{_settled_table(data)}
### The whole picture

{figure("fig7")}
How often PRS's RMS error is a sampler's own, with the treatment from pixel to pixel:

{_ratio_table(data)}
N matters: 64 is a power of two and 81 is not. Owen-Sobol' is at its best where each cell of a grid holds exactly one
point. Its own error: the converged reference is known to {_own_error(data):.1e} of white in the penumbra.

{figure("fig7_treatments")}
### Where "nearly 3 times" comes from

The paper finds PRS almost three times as bad as Halton with 81 points, nothing occluding. PRS / Halton and PRS /
Sobol', both with the same points in each pixel, by ways of measuring (bare ground, then with the sphere):

{_ways_table(data)}
The paper's reference was itself PRS with 10^4 points: its own error is a ninth of PRS's error at 81 points and hides
how good the others are. Pixels of 8 bits add rounding on top. Both push the ratio towards the paper's 3.

### In the penumbra

{figure("fig7_penumbra")}
{_slope_table(data)}"""


def _settled_table(data: Data) -> str:
    rows = []
    for (part, shape, start), medians in settled_medians(data).items():
        rows.append([f"{part}, {shape}, {start}", *(text for _, text in medians.values())])
    return markdown(["place, luminaire, start", *(NAMES[m.sampler] for m in SHOWN)], rows)


def settled_medians(data: Data) -> dict:
    """(part, shape, start) -> sampler -> (median count, the same as text)."""
    settled, most = data.read("fig6_settled"), max(row["points"] for row in data.read("fig6_curves"))
    found = {}
    for key in dict.fromkeys((row["part"], row["shape"], row["start"]) for row in settled):
        here = where(settled, part=key[0], shape=key[1], start=key[2])
        found[key] = {}
        for method in SHOWN:
            median = statistics.median(row["settled_at"] for row in where(here, sampler=method.sampler))
            found[key][method.sampler] = median, f"> {most}" if median > most else f"{median:.0f}"
    return found


def ratio_to_prs(data: Data, scene: str, sampler: str, reuse: str, points: int, column: str = "rmse") -> float:
    rows = where(data.read("fig7_errors"), scene=scene, points=points)
    return one(rows, sampler="PRS")[column] / one(rows, sampler=sampler, reuse=reuse)[column]


def _ratio_table(data: Data) -> str:
    cases = [(scene, n) for scene in ("unoccluded", "occluded") for n in (16, 64, MEASURED_AT)]
    return markdown(
        ["PRS / it", *(f"{scene}, N = {n}" for scene, n in cases)],
        [[m.label, *(times(ratio_to_prs(data, scene, *m, n)) for scene, n in cases)] for m in ALL[1:]],
    )


def way_ratio(data: Data, scene: str, way: str, sampler: str) -> float:
    rows = where(data.read("fig7_ratios_at_81"), scene=scene, way=way)
    return one(rows, sampler="PRS")["error"] / one(rows, sampler=sampler, reuse="SAME")["error"]


def _ways_table(data: Data) -> str:
    ways = dict.fromkeys(row["way"] for row in data.read("fig7_ratios_at_81"))
    cases = [(scene, sampler) for scene in ("unoccluded", "occluded") for sampler in ("HALTON", "SOBOL")]
    return markdown(
        ["reference, pixels, formula", *(f"{NAMES[sampler]}, {scene}" for scene, sampler in cases)],
        [[way, *(f"{way_ratio(data, scene, way, sampler):.2f}" for scene, sampler in cases)] for way in ways],
    )


def penumbra_slope(data: Data, sampler: str, reuse: str) -> float:
    rows = [row for row in where(data.read("fig7_errors"), scene="occluded", sampler=sampler, reuse=reuse)
            if row["points"] in SLOPE_POINTS]  # fmt: skip
    return metrics.slope([row["points"] for row in rows], [row["penumbra_relative_rmse"] for row in rows])


def _slope_table(data: Data) -> str:
    most = max(row["points"] for row in data.read("fig7_errors"))
    counts = ", ".join(str(n) for n in SLOPE_POINTS if n <= most)
    return markdown(
        ["points", f"slope of the error over N = {counts}"],
        [[method.label, f"{penumbra_slope(data, *method):.2f}"] for method in ALL],
    )


def _own_error(data: Data) -> float:
    return max(row["reference_own_error"] for row in data.read("fig7_errors"))
