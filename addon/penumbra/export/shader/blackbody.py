# SPDX-License-Identifier: GPL-3.0-or-later
"""The colour of a glowing body."""

import numpy as np

SECOND_RADIATION_CONSTANT = 1.438776877e7
"""h c / k in nm K."""
LOBES = (
    ((1.056, 599.8, 37.9, 31.0), (0.362, 442.0, 16.0, 26.7), (-0.065, 501.1, 20.4, 26.2)),
    ((0.821, 568.8, 46.9, 40.5), (0.286, 530.9, 16.3, 31.1)),
    ((1.217, 437.0, 11.8, 36.0), (0.681, 459.0, 26.0, 13.8)),
)
"""The CIE 1931 observer's x, y, z as sums of Gaussians: height, centre, width to either side in nm (Wyman, Sloan and
Shirley 2013, "Simple Analytic Approximations to the CIE XYZ Color Matching Functions")."""
REC709_FROM_XYZ = np.array([[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]])
COOLEST, HOTTEST = 800.0, 12000.0
"""Between them Cycles' own fit is made; beyond them it stays the same."""


def blackbody(kelvin: float) -> tuple[float, float, float]:
    """Linear Rec. 709 of a black body, of luminance 1; components below zero are zero."""
    wavelength = np.arange(380.0, 781.0, 1.0)
    exponent = SECOND_RADIATION_CONSTANT / (wavelength * min(max(kelvin, COOLEST), HOTTEST))
    spectrum = wavelength**-5 / np.expm1(exponent)
    xyz = [
        sum(h * np.exp(-0.5 * ((wavelength - c) / np.where(wavelength < c, low, high)) ** 2) for h, c, low, high in one)
        @ spectrum
        for one in LOBES
    ]
    return tuple(float(c) for c in np.maximum(REC709_FROM_XYZ @ xyz / xyz[1], 0.0))
