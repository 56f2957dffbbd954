# SPDX-License-Identifier: GPL-3.0-or-later
"""Chapter: the BRDF, mirror + Phong + diffuse."""

import numpy as np
from measure.brdf import FURNACE_ALBEDO, ROUGHNESSES
from tables import Data, markdown, one, where

from .words import figure


def tell(data: Data) -> str:
    furnace = data.read("brdf_furnace")
    angles = list(dict.fromkeys(row["degrees"] for row in furnace))
    table = markdown(
        ["roughness (exponent)", *(f"{a} degrees" for a in angles)],
        [[f"{r:g} ({one(furnace, roughness=r, degrees=0)['exponent']:.1f})",
          *(f"{row['reflected']:.3f} ({row['exact']:.3f})" for row in where(furnace, roughness=r))]
         for r in dict.fromkeys(row["roughness"] for row in furnace)],
    )  # fmt: skip
    widths = markdown(
        ["roughness", "Phong, degrees", "Cycles' GGX, degrees", "ratio"],
        [[f"{r:g}", f"{w[0]:.1f}", f"{w[1]:.1f}", f"{w[0] / w[1]:.2f}"]
         for r in ROUGHNESSES for w in [[half_width(data, r, e) for e in ("PENUMBRA", "CYCLES")]]],
    )  # fmt: skip
    return f"""## 6. Surfaces: mirror + Phong + diffuse

{figure("brdf")}
The paper sums a mirror, a Phong and a diffuse term and says no more. Here each has an albedo, and their sum is at
most 1:

- diffuse: f = albedo / pi;
- Phong: f = albedo (n + 2) / (2 pi) cos^n(a), a the angle between the light and the mirror direction: the modified
  Phong model of Lafortune and Willems (1994), *normalised* so that at normal incidence exactly the albedo comes back
  and *energy-conserving* because at any other angle part of the lobe lies below the surface and less comes back;
- mirror: the albedo times what the mirror direction sees, followed `mirror_depth` times.

From Blender: a Diffuse BSDF is the diffuse term, a Glossy BSDF of roughness 0 the mirror, one with the distribution
Ashikhmin-Shirley a Phong lobe; Mix and Add Shader weight and sum them. The exponent is n = 1 / (2 alpha^2) - 1/2 with
alpha = roughness^2, as Cycles has it: a microfacet distribution of roughness alpha is close to Blinn's lobe of exponent
2 / alpha^2 - 2 in the half-vector's angle (Walter et al. 2007), which is half the angle to the mirror direction, hence
a quarter of it. What a material has beyond this gets a note in the log.

A furnace: a plane of Phong albedo {FURNACE_ALBEDO:g} under a luminaire that fills 98.8 % of its sky
(cosine-weighted). Light sent back, in units of the luminaire's radiance, by the engine (and by a midpoint sum of the
formula), against the angle of view:

{table}
Is the lobe as wide as that of Cycles? The highlight's half width at half its peak:

{widths}
{figure("brdf_lobes")}
GGX has a narrower peak and longer tails than any Phong lobe. For small roughness theory gives half widths of 1.67 and
1.29 alpha (ratio 1.29), while the half-energy widths are in the ratio 0.83: the mapping lies between.
"""


def half_width(data: Data, roughness: float, engine: str) -> float:
    """Degrees from the peak to half of it, the mean of both sides."""
    rows = where(data.read("brdf_lobes"), roughness=roughness, engine=engine)
    degrees, radiance = (np.array([row[key] for row in rows]) for key in ("degrees", "radiance"))
    above = radiance >= radiance.max() / 2
    return float((degrees[above].max() - degrees[above].min()) / 2)
