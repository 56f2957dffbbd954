# SPDX-License-Identifier: GPL-3.0-or-later
"""Chapter: Fig. 4 and 5, soft shadows to look at."""

from measure.crops import SHOWN
from scenes import LIGHT_HEIGHT, LIGHT_SIDE, SPHERE_RADIUS
from tables import Data, markdown, one

from .words import figure


def tell(data: Data) -> str:
    rows = data.read("fig5_errors")
    table = markdown(
        ["points", "RMS error", "mean absolute error"],
        [[m.label, f"{r['rmse']:.4f}", f"{r['mean_absolute']:.4f}"]
         for m in SHOWN for r in [one(rows, sampler=m.sampler, reuse=m.reuse)]],
    )  # fmt: skip
    difference = data.read("fig4_through_blender")[0]["largest_difference"]
    return f"""## 2. A soft shadow

{figure("fig4")}
The paper gives no measures. Here the sphere has a radius of {SPHERE_RADIUS} m, the luminaire a side of {LIGHT_SIDE} m,
{LIGHT_HEIGHT} m above the ground; the surfaces are Lambertian with albedos of 0.7 and 0.8; each pixel has one ray
through its centre, as in the paper. The picture went all the way through Blender's own render; the same scene
rendered directly by the native module differs from it by at most {difference:g}.

{figure("fig5")}
{table}
"Same" means that all pixels use the same points, "rotated" that each pixel shifts them by a random offset (Cranley and
Patterson). The paper does not say which it did. It matters more than Sobol' or Halton: the same points in each pixel
turn the error into steps, independent ones turn it into grain, as PRS does.
"""
