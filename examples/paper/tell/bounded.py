# SPDX-License-Identifier: GPL-3.0-or-later
"""Chapter: Fig. 8 and 9, error-bounded sampling, and whether its bound holds."""

from typing import NamedTuple

import numpy as np
from measure.bound import FEWEST_POINTS, METHODS, PAPER_EPS, RULES, TOLERANCES
from measure.matched_rays import DARK_SPECK
from methods import NAMES, OWEN_SOBOL, SOBOL
from tables import Data, markdown, one, where

from .words import figure, millions, percent

WAYS = ("MC-FS", "MC-EBLS", "QMC-FS", "QMC-EBLS")
SETTINGS = {
    "PAPER": "the running means of r, g, b have moved by less than eps over the last 5 points",
    "standard error": "sqrt(V / n) < eps, V the sample variance (this engine's `VARIANCE`)",
    "variance of the mean": "V / n < eps, the paper's V(L) < eps read literally: the test above with sqrt(eps)",
    "BOUNDED": "this engine's own rule, not the paper's: exact unshadowed light times a sampled visible share, "
    "errors pooled over neighbours",
}


def tell(data: Data) -> str:
    difference = data.read("fig8_through_blender")[0]["largest_difference"]
    height, width = data.read_pictures("fig9")["classes"].shape
    share = data.read("bound")[0]
    return f"""## 4. As many points as needed: error-bounded luminaire sampling

A lit floor needs few points and a penumbra many. The paper's EBLS adds points one by one and stops when the running
mean has moved by less than eps = 0.004 (about 1/255 of white) since 5 points before.

{figure("fig8")}
Rays are matched as in the paper: (d) QMC-EBLS first; (c) QMC-FS with the smallest fixed number that takes at least
(d)'s rays; (b) MC-EBLS with (d)'s rule; (a) MC-FS with at least (b)'s. The paper's (d) took 10.9 million rays; the
picture here has {width} x {height} pixels, chosen by that budget (a tenth of it in a quick run). The paper names
neither the scene's measures nor how pixels share the sequence, so three kinds of QMC are run. The picture above and
the native one differ by {difference:g}.

{figure("fig9")}
{_table(data)}
Dark specks are penumbra pixels more than {DARK_SPECK:g} of white too dark: what the paper saw in (a). Sobol' points
are at their best in whole powers of two, so a fixed number close to 16 does well for its rays; EBLS stops at 10, 15,
20 ... and, with the same points in each pixel, stops falsely in whole regions at once.

{figure("fig9_points")}
Is time proportional to rays? Lines through the runs of each kind, on one thread (R^2: 1 is a perfect fit):

{_time_table(data)}
The seconds at no rays are those of the pixels themselves. A PRS point costs more to make than one read from a table;
and the engine traces packets of 16, so EBLS throws away part of a packet's rays, which the paper's way of counting
leaves out but which take their time.

{figure("time_and_rays")}
## 5. Does the bound hold?

EBLS promises that each pixel is within eps, "the necessary and sufficient number of samples". Against a converged
picture, known to {share["reference_own_error"]:.1e} in the penumbra, on the scene of Fig. 8:
{percent(share["share_lit"])} of its pixels are wholly lit, {percent(share["share_penumbra"])} in penumbra,
{percent(share["share_umbra"])} in the umbra or turned away. A pixel misses if the largest error of r, g, b is above
eps. The rules:

{_rules()}
{figure("bound")}
{_bound_table(data)}
"False stops" are penumbra pixels beyond eps that stopped at the first look, after {FEWEST_POINTS} points: all of those
agreed, often because all were hidden (the dark crescents of Fig. 9 (d)). "p99 / eps": the 99th percentile of the
error, in units of eps. All tolerances are in bound.csv.

{figure("bound_map")}
How much this depends on the scene, at eps = {PAPER_EPS:g}: the same rule on the scene of
`examples/make_four_objects.py`, whose luminaire is twice as far from the floor, so that less of the picture is in
penumbra and the lit floor is more even.

{_other_scene(data)}"""


def _table(data: Data) -> str:
    rows = []
    for row in data.read("fig9_errors"):
        name = "BOUNDED (this engine's own)" if row["method"] == "BOUNDED" else f"{row['method']}, {row['qmc']}"
        if row["method"].startswith("MC") and row["qmc"] != SOBOL.label:
            continue  # the same picture, rendered beside each kind of QMC
        name = row["method"] if row["method"].startswith("MC") else name
        rows.append([
            name, str(row["fixed_points"] or "-"), millions(row["rays"]), f"{row['seconds']:.2f}", f"{row['rmse']:.5f}",
            f"{row['rmse_penumbra']:.4f}", percent(row["dark_specks"]), percent(row["over_tolerance"]),
            f"{row['points_lit']:.1f} / {row['points_penumbra']:.1f}",
        ])  # fmt: skip
    head = ["method", "fixed N", "rays", "CPU s", "RMSE", "RMSE, penumbra", "dark specks", "error > 0.004",
            "points, lit / penumbra"]  # fmt: skip
    return markdown(head, rows)


class TimeLine(NamedTuple):
    """seconds = start + rays x a_ray, and how well that fits."""

    kind: str
    a_ray: float
    start: float
    r_squared: float
    mean_seconds: float


def time_lines(data: Data) -> list[TimeLine]:
    """One for each stop rule and sampler."""
    rows, lines = data.read("time_and_rays"), []
    for rule, sampler in dict.fromkeys((row["rule"], row["sampler"]) for row in rows):
        some = where(rows, rule=rule, sampler=sampler)
        rays, seconds = (np.array([row[key] for row in some], float) for key in ("rays", "seconds"))
        line = np.polyfit(rays, seconds, 1)
        fit = 1 - np.var(seconds - np.polyval(line, rays)) / np.var(seconds)
        lines.append(TimeLine(f"{rule}, {NAMES[sampler]}", line[0], line[1], float(fit), float(seconds.mean())))
    return lines


def _time_table(data: Data) -> str:
    return markdown(
        ["runs", "ns a ray", "seconds at no rays", "R^2"],
        [[line.kind, f"{1e9 * line.a_ray:.0f}", f"{line.start:.3f}", f"{line.r_squared:.2f}"]
         for line in time_lines(data)],
    )  # fmt: skip


def _rules() -> str:
    return "\n".join(f"- **{rule}**: stop when {text}" if rule != "BOUNDED" else f"- **{rule}**: {text}"
                     for rule, text in SETTINGS.items()) + "\n"  # fmt: skip


def _bound_table(data: Data) -> str:
    rows = []
    for rule in RULES:
        for method in [OWEN_SOBOL] if rule == "BOUNDED" else METHODS:
            for eps in TOLERANCES:
                row = one(data.read("bound"), rule=rule, sampler=method.sampler, reuse=method.reuse, eps=eps)
                if eps in (0.01, PAPER_EPS, 0.001):
                    rows.append([f"{rule}, {method.label}, {eps:g}", *_judged(row)])
    return markdown(["rule, points, eps", *JUDGED], rows)


JUDGED = ("miss", "lit", "penumbra", "false stops", "p99 / eps", "rays a pixel", "at the limit of 8192")


def _judged(row) -> list[str]:
    return [percent(row["beyond"]), percent(row["beyond_lit"]), percent(row["beyond_penumbra"]),
            percent(row["false_stops"]),
            f"{row['p99_over_eps']:.1f}", f"{row['light_rays_per_pixel']:.1f}", percent(row["at_limit"])]  # fmt: skip


def _other_scene(data: Data) -> str:
    here = where(data.read("bound"), rule="PAPER", eps=PAPER_EPS)
    there = data.read("bound_other_scene")
    rows = [[f"{place}, {method.label}", *_judged(one(rows_, sampler=method.sampler, reuse=method.reuse))]
            for place, rows_ in (("Fig. 8", here), ("examples", there)) for method in METHODS]  # fmt: skip
    return markdown(["scene, points", *JUDGED], rows)
