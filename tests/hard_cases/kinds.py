# SPDX-License-Identifier: GPL-3.0-or-later
"""A luminaire of every kind over the floor z = 0, that can be moved, and the exact light that it sends to the floor."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import oracles
from methods import UP
from scenes import add, apply, box, parallelogram, rotation, translation

ABOVE = translation(0, 0, 2)
TILT = ABOVE @ rotation([1, 1, 0], 35)
LONG, OVAL = (2.0, 0.3), (1.5, 0.3)
CONE, BLEND = np.radians(70), 0.6
BOX = box([-0.3, -0.3, 1.6], [0.3, 0.3, 2.2])
SKY = np.repeat(np.array([0.0, 0.2, 1.0, 3.0], np.float32)[:, None, None], 8, axis=1).repeat(3, axis=2)
"""Rows of a picture from straight down up, without azimuth."""


@dataclass(frozen=True)
class Kind:
    """add(scene, matrix, power) adds it where a similarity moves it; exact(at) is pi^-1 times the irradiance of the
    floor's points (..., 3) at power 1, None where there is no closed form."""

    add: Callable
    exact: Callable | None
    far: bool = False
    """at infinity"""
    turns: bool = True
    """Its points turn with it; those of round ones turn about the axis to the surface point."""


def size_of(matrix):
    return np.cbrt(np.linalg.det(matrix[:3, :3]))


def area(shape, size, place=ABOVE, **named):
    def to(scene, matrix, power):
        scene.add_area_light("key", shape, matrix @ place, size, (power,) * 3, **named)

    return to


def polygon(corners, place):
    return lambda at: oracles.lambert_on(corners, at, UP, -place[:3, 2])


def ball(radius, **named):
    def to(scene, matrix, power):
        s = size_of(matrix)
        scene.add_point_light("key", matrix @ ABOVE, radius * s, (power * s * s,) * 3, **named)

    return to


def from_point(at, radius=0.0, falloff=lambda cosine: 1.0):
    """I cos / d^2, which a whole sphere sends, too; from a disk that faces the point I cos / (d^2 + r^2)."""
    to_light = ABOVE[:3, 3] - at
    square = (to_light**2).sum(-1)
    cosine = to_light[..., 2] / np.sqrt(square)
    return cosine / (square + radius**2) / np.pi * falloff(cosine)


def cone(cosine):
    edge = np.cos(CONE / 2)
    inside = np.clip((cosine - edge) / ((1 - edge) * BLEND), 0, 1)
    return inside**2 * (3 - 2 * inside)


def sun(angle):
    def to(scene, matrix, power):
        scene.add_sun("key", tuple(matrix[:3, :3] @ [0.5, 0, 1]), angle, (power,) * 3)

    return to


def sky(image):
    def to(scene, matrix, power):
        turn = np.eye(4)
        turn[:3, :3] = matrix[:3, :3].T / size_of(matrix)
        scene.set_background((power,) * 3, lights=True, image=image, local_from_world=turn, smooth=False)

    return to


def sky_rows(at):
    """Ring by ring: the integral of cos sin from one zenith distance to the next."""
    edges = np.sin(np.pi * np.arange(len(SKY) // 2 + 1) / len(SKY)) ** 2
    return np.full(at.shape[:-1], (np.diff(edges) * SKY[::-1, 0, 0][: len(SKY) // 2]).sum())


def mesh(shape):
    def to(scene, matrix, power):
        add(scene, "key", (apply(matrix, shape[0]), shape[1]), albedo=0)
        scene.add_mesh_light("key", *shape, matrix, (power,) * 3)

    return to


def faces(shape):
    """Of a closed convex body: those that the point sees."""

    def exact(at):
        total = 0
        for corners in shape[0][shape[1]]:
            outward = np.cross(corners[1] - corners[0], corners[2] - corners[0])
            total = total + oracles.lambert_on(corners, at, UP, outward)
        return total

    return exact


def constant(value):
    return lambda at: np.full(at.shape[:-1], value)


SQUARE = parallelogram([-0.5, -0.5, 2], [1, 0, 0], [0, 1, 0])


def square(at):
    return oracles.parallel_rectangle(at[..., 0], at[..., 1], 0.5, 2)


KINDS = {
    "square": Kind(area("RECTANGLE", (1, 1)), square),
    "rectangle": Kind(area("RECTANGLE", LONG, TILT), polygon(oracles.rectangle_corners(TILT, LONG), TILT)),
    "disk": Kind(area("ELLIPSE", (1, 1)), lambda at: oracles.disk(0.5, 2, np.hypot(at[..., 0], at[..., 1]))),
    "ellipse": Kind(area("ELLIPSE", OVAL, TILT), polygon(oracles.ellipse_corners(TILT, OVAL, 4096), TILT)),
    "spread": Kind(area("RECTANGLE", (1, 1), spread=2.0), None),
    "sphere": Kind(ball(0.5), from_point, turns=False),
    "facing disk": Kind(ball(0.5, shape="FACING_DISK"), lambda at: from_point(at, 0.5), turns=False),
    "point": Kind(ball(0), from_point),
    "spot": Kind(ball(0, spot=(CONE, BLEND)), lambda at: from_point(at, 0, cone)),
    "soft spot": Kind(ball(0.3, spot=(CONE, BLEND), cosine_falloff=True), None, turns=False),
    "sharp sun": Kind(sun(0), constant(np.cos(np.arctan(0.5)) / np.pi), far=True),
    "sun": Kind(sun(0.4), constant(np.cos(np.arctan(0.5)) / np.pi), far=True, turns=False),
    "sky": Kind(sky(None), constant(1.0), far=True, turns=False),
    "painted sky": Kind(sky(SKY), sky_rows, far=True),
    "glowing square": Kind(mesh(SQUARE), square, turns=False),
    "glowing box": Kind(mesh(BOX), faces(BOX), turns=False),
}
CLOSED_FORMS = {name: kind for name, kind in KINDS.items() if kind.exact}
