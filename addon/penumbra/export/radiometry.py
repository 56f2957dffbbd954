# SPDX-License-Identifier: GPL-3.0-or-later
"""From Blender's units of light to radiance, intensity and irradiance. Each law was measured against Cycles."""

import math

from .. import compat

Colour = tuple[float, float, float]


def scaled(factor: float, colour) -> Colour:
    return tuple(factor * component for component in colour)


def area_radiance(power: float, colour: Colour, area: float) -> Colour:
    """Radiance (r, g, b) in W/(sr m^2) leaving the emitting side of an area light.

    power: Blender's watts. area: the true area in square metres, the object's scale included. The law is Blender's own,
    which changed with 4.0: P / (4 A) before, P / (pi A), the radiance of a Lambertian emitter of P watts, since.
    """
    divisor = 4.0 if compat.AREA_LIGHT_WATTS_OVER_FOUR_AREAS else math.pi
    return scaled(power / (divisor * area), colour)


def point_intensity(power: float, colour: Colour) -> Colour:
    """Intensity (r, g, b) in W/sr of a point light or spot of any radius."""
    return scaled(power / (4 * math.pi), colour)


def extent_of_ball(radius: float) -> float:
    """What a point light's or spot's power is multiplied with where it is not normalized: its surface.

    Of radius 0 it is 4, as Cycles then takes the area pi r^2 of its disk for 1.
    """
    return 4 * math.pi * radius**2 if radius > 0 else 4.0


def extent_of_sun(angle: float) -> float:
    """The same for a sun: its projected solid angle, 1 for a single direction."""
    return math.pi * math.sin(angle / 2) ** 2 if angle > 0 else 1.0


def sun_irradiance(strength: float, colour: Colour, angle: float) -> Colour:
    """Irradiance (r, g, b) in W/m^2 of a surface that faces the sun.

    Before 4.0 Cycles' sun is a flat disk at distance 1, whose points have equal shares: their mean cosine is
    2 (sqrt(1 + r^2) - 1) / r^2 for r = tan(angle / 2), written here without its cancellation.
    """
    if compat.SUN_IS_FLAT:
        strength *= 2 / (1 + math.sqrt(1 + math.tan(angle / 2) ** 2))
    return scaled(strength, colour)
