# SPDX-License-Identifier: GPL-3.0-or-later
"""Chapter: the points themselves, and what a careless use of them does."""

from methods import NAMES, REUSES
from tables import Data, markdown, one, where

from .words import figure


def tell(data: Data) -> str:
    rows, costs = data.read("fig1_discrepancies"), data.read("cost_of_a_point")
    samplers = list(dict.fromkeys(row["sampler"] for row in rows))
    counts = list(dict.fromkeys(row["points"] for row in rows))
    uneven = markdown(
        ["discrepancy", *(f"{n} points" for n in counts)],
        [[NAMES[s], *(f"{one(rows, sampler=s, points=n)['discrepancy']:.4f}" for n in counts)] for s in samplers],
    )
    heads = [f"{reuse.lower()}: {what}" for what in ("made", "in a picture") for reuse in REUSES]
    cost = markdown(
        ["nanoseconds a point", *heads],
        [[NAMES[s], *_costs(costs, s, "made_ns"), *_costs(costs, s, "in_a_picture_ns")] for s in samplers],
    )
    prs, sobol, halton = (one(costs, sampler=s, reuse=r)["made_ns"]
                          for s, r in (("PRS", "SAME"), ("SOBOL", "CONTINUED"), ("HALTON", "CONTINUED")))  # fmt: skip
    stride = data.read("stride_errors")
    careful, striding = (one(stride, picture=p) for p in ("careful", "striding"))
    return f"""## 1. Points in a square

A soft shadow is an integral over the luminaire's area, and the renderer estimates it from points on that area. The
paper's question is which points to take. Five kinds appear here: **PRS**, pseudo-random pairs from `drand48()` (plain
Monte Carlo, "MC"); **SPRS**, one random point in each of n x n cells (stratified); **Sobol'** with the direction
numbers of Numerical Recipes and **Halton** in bases 2 and 3 (quasi-Monte Carlo, "QMC"); and, not in the paper,
**Owen-Sobol'**, a (0,2)-sequence whose digits are scrambled at random by Owen's method.

{figure("fig1")}
How uneven they are, as a number: the L2 star discrepancy, the root mean square over all boxes at the origin of the
share of points inside minus the box's area.

{uneven}
{figure("fig2")}
### What careless use of that does to a picture

If a pixel takes every other point of the sequence, it sees half of the luminaire. Below, the pixels of even columns
take the even points and those of odd columns the odd ones, as a program does that hands the next point to the next
pixel of a row of even length. The engine has no such mode: this one figure is computed outside it, in NumPy, from its
points, its surface positions and its normals. The careful version made in the same way agrees with the engine's own
picture to a root mean square of {careful["rmse_against_engine"]:.5f} of white (the sphere is exact here and a mesh
there). The error of striding is {striding["rmse"] / careful["rmse"]:.1f} times that of the careful use.

{figure("stride")}
### What a point costs

The paper measured 1 us for a Sobol' point, 2.5 us for a PRS pair and 20 us for Halton on a 100 MHz PowerPC. Here each
point takes nanoseconds; "made" is one call for 16,384 points of one pixel, table and copying to NumPy included; "in a
picture" is a whole render without shadow rays, per point, so the share of eq. (4) is in it. `same`, `rotated` and
`scrambled` read the sequence from a table made once for a picture; `continued` makes each point anew. PRS and SPRS
always draw anew.

{cost}
One point after the other (`continued`), Sobol' costs {sobol / prs:.1f} times as much as PRS (paper: 0.4) and Halton
{halton / prs:.1f} times (paper: 8). Halton's digits in base 3 need divisions, and scrambling them is dearer still.
"""


def _costs(rows, sampler: str, column: str) -> list[str]:
    found = {row["reuse"]: f"{row[column]:.1f}" for row in where(rows, sampler=sampler)}
    return [found.get(reuse, "-") for reuse in REUSES]
