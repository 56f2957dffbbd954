# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes of different kinds for the error promise. None of them was used to find BOUNDED's constants."""

import numpy as np
import penumbra_native as pn
from scenes import add, box, floor, rotation, scaling, sphere, translation

ALBEDO = 0.8


class Stage:
    """A floor, seen obliquely from above; luminaires are made so that white is the largest unshadowed value."""

    def __init__(self, shadows=True):
        self.scene, self.shadows, self.count = pn.Scene(), shadows, 0
        self.add(floor(half=20.0))
        eye, target = np.array([5.0, -9.0, 7.0]), np.array([0.0, 0.0, 0.5])
        back = (eye - target) / np.linalg.norm(eye - target)
        right = np.cross([0, 0, 1], back) / np.linalg.norm(np.cross([0, 0, 1], back))
        camera = np.eye(4)
        camera[:3] = np.stack([right, np.cross(back, right), back, eye], axis=1)
        self.camera = camera
        self.scene.set_camera("PERSPECTIVE", camera, (-0.5, 0.5, -0.375, 0.375), (0.01, 1000.0))

    def add(self, shape, matrix=None, albedo=ALBEDO):
        self.count += 1
        add(self.scene, f"object {self.count}", shape, matrix, albedo=albedo)

    def light(self, x, y, z, size, shape="RECTANGLE", white=1.0):
        radiance = white / ALBEDO * np.pi * z * z / (size[0] * size[1])
        self.scene.add_area_light("light", shape, translation(x, y, z), size, (radiance,) * 3, self.shadows)

    def bulb(self, x, y, z, radius, white=1.0, **more):
        """Intensity / (pi z^2) x albedo is the floor's radiance below a point."""
        intensity = (white / ALBEDO * np.pi * z * z,) * 3
        self.scene.add_point_light("bulb", translation(x, y, z), radius, intensity, self.shadows, **more)

    def glow(self, shape, matrix, radiance):
        """A mesh that is a luminaire and an occluder."""
        self.add(shape, matrix)
        if self.shadows:
            self.scene.add_mesh_light("glow", *shape, matrix, (radiance,) * 3)


def leaves(count, size, seed, half=2.5, height=1.5):
    """Rhombi of random place and direction in a box over the floor."""
    rng = np.random.default_rng(seed)
    centre = rng.uniform([-half, -half, 0.05], [half, half, height], (count, 3))
    a, b = rng.normal(size=(2, count, 3))
    a *= size / np.linalg.norm(a, axis=1, keepdims=True)
    b = np.cross(a, b)
    b *= 0.4 * size / np.linalg.norm(b, axis=1, keepdims=True)
    positions = np.stack([centre - a, centre + b, centre + a, centre - b], axis=1).reshape(-1, 3)
    i = 4 * np.arange(count)
    return positions, np.concatenate([np.stack([i, i + 1, i + 2], 1), np.stack([i, i + 2, i + 3], 1)]).astype(np.int32)


def column(sides, radius=0.8, height=1.6):
    """A cylinder without caps, of flat sides."""
    angle = 2 * np.pi * np.arange(sides) / sides
    ring = np.stack([radius * np.cos(angle), radius * np.sin(angle), np.zeros(sides)], axis=1)
    i, j = np.arange(sides), (np.arange(sides) + 1) % sides
    triangles = np.concatenate([np.stack([i, j, j + sides], 1), np.stack([i, j + sides, i + sides], 1)])
    return np.concatenate([ring, ring + [0, 0, height]]), triangles.astype(np.int32)


def columns(stage):
    """Flat sides from several pixels wide to far below one: light at a pixel's centre is not that of the pixel."""
    for x, y, sides in ((-1.6, 0.4, 30), (0.3, -0.6, 90), (2.2, 0.3, 300)):
        stage.add(column(sides), translation(x, y, 0))
    stage.light(-2, -3, 5, (1.5, 1.5))


def squares(stage):
    """A checkered floor under an open sky: edges everywhere, and nothing that hides a luminaire."""
    z = 1e-5  # above the floor: its shadow is not seen
    for i in range(-5, 5):
        for j in range(-5, 5):
            if (i + j) % 2 == 0:
                positions = np.array([[i, j, z], [i + 1, j, z], [i + 1, j + 1, z], [i, j + 1, z]])
                stage.add((positions, np.array([[0, 1, 2], [0, 2, 3]], np.int32)), albedo=0.3)
    stage.light(0.5, 0.5, 5, (2, 2))


def open_floor(stage):
    stage.light(0.5, 0.5, 5, (2, 2))


def solid_shapes(stage):
    stage.add(sphere([-1.2, 0.8, 1.0], 1.0, 32))
    stage.add(box([0.5, -1.5, 0.0], [1.7, -0.4, 1.4]))
    stage.add(sphere([1.5, 1.6, 0.5], 0.5, 24), scaling(1, 1, 1.6))


def solid_objects(stage):
    solid_shapes(stage)
    stage.light(2.0, -2.0, 5, (1.5, 1.5))


def hues(stage):
    """Surfaces of other hues beside each other, some in shadow: what one of them hides is not what another does."""
    red, green, blue = (0.8, 0.06, 0.06), (0.06, 0.8, 0.06), (0.06, 0.06, 0.8)
    rng = np.random.default_rng(79)
    for i in range(30):
        radius, at = rng.uniform(0.15, 0.45), rng.uniform(-2.5, 2.5, 2)
        place = translation(*at, radius * rng.uniform(1, 3))
        stage.add(sphere([0, 0, 0], radius, 20), place, (red, green, blue)[i % 3])
    stage.add(box([-0.4, -1.6, 0.0], [0.5, -0.8, 1.2]), albedo=green)
    stage.light(2.0, -2.0, 5, (1.0, 1.0))


def slanted_fence(stage):
    turn = rotation([0, 0, 1], 25)
    for i in range(26):
        stage.add(box([-0.025, -0.015, 0], [0.025, 0.015, 1.6]), turn @ translation(-3 + 0.24 * i, 0, 0))
    stage.light(-1.0, 4.0, 5, (2.5, 1.0))


def wires(stage):
    rng = np.random.default_rng(71)
    for _ in range(16):
        at = translation(*rng.uniform(-2, 2, 2), rng.uniform(0.3, 1.5))
        stage.add(box([-2, -0.012, -0.012], [2, 0.012, 0.012]), at @ rotation([0, 0, 1], rng.uniform(0, 180)))
    stage.light(-1.0, 0.5, 5, (1.2, 1.2))


def blinds(stage):
    for i in range(14):
        slat = translation(0, -2 + 0.3 * i, 1.5) @ rotation([1, 0, 0], 35)
        stage.add(box([-2, -0.1, -0.004], [2, 0.1, 0.004]), slat)
    stage.light(0.5, 1.0, 5, (1.0, 1.0))


def foliage(stage):
    stage.add(leaves(2500, 0.12, seed=72))
    stage.light(2.0, 1.0, 6, (2, 2))


def ellipse_and_square(stage):
    stage.add(sphere([0, 0, 0.9], 0.8, 32))
    stage.add(leaves(200, 0.2, seed=73))
    stage.light(2.0, -1.0, 5, (2.0, 1.0), "ELLIPSE", 0.6)
    stage.light(-3.0, 1.0, 4, (0.5, 0.5), "RECTANGLE", 0.4)


def many_luminaires(stage):
    rng = np.random.default_rng(74)
    for _ in range(12):
        x, y = rng.uniform(-3, 3, 2)
        stage.add(box([x - 0.3, y - 0.3, 0], [x + 0.3, y + 0.3, rng.uniform(0.3, 1.2)]))
    for i in range(16):
        stage.light(-4.5 + 3 * (i % 4), -4.5 + 3 * (i // 4), 4, (0.4, 0.4), white=0.25)


def ball(stage):
    solid_shapes(stage)
    stage.bulb(2.0, -2.0, 4.0, 0.5)


def balls(stage):
    """Of many sizes, under lamps turned away from them: much gets next to no light of one or the other."""
    rng = np.random.default_rng(8)
    for _ in range(40):
        radius = 10 ** rng.uniform(-1.7, -0.1)
        stage.add(sphere([0, 0, 0], radius, 24), translation(*rng.uniform(-2.5, 2.5, 2), radius * rng.uniform(0.9, 3)))
    for x, y, z, size, white in ((-2.0, 1.2, 2.7, 0.19, 0.4), (0.9, -0.2, 5.3, 2.3, 0.4), (-1.4, 0.9, 5.0, 0.18, 0.4)):
        place = translation(x, y, z) @ rotation([-y, x, 0.01], -30)
        radiance = white / ALBEDO * np.pi * z * z / size**2
        stage.scene.add_area_light("lamp", "ELLIPSE", place, (size, 0.7 * size), (radiance,) * 3, stage.shadows)
    eye, back = np.array([-0.38, -7.0, 3.9]), np.array([-0.38, -7.0, 3.5])
    back /= np.linalg.norm(back)
    right = np.cross([0, 0, 1], back) / np.linalg.norm(np.cross([0, 0, 1], back))
    stage.camera[:3] = np.stack([right, np.cross(back, right), back, eye], axis=1)
    stage.scene.set_camera("PERSPECTIVE", stage.camera, (-0.4, 0.4, -0.3, 0.3), (0.01, 1000.0))


def spots(stage):
    solid_shapes(stage)
    stage.add(leaves(200, 0.2, seed=75))
    stage.bulb(2.5, -1.0, 4.0, 0.3, 0.6, spot=(1.2, 0.3))
    stage.bulb(-3.0, 1.0, 4.0, 0.0, 0.4, spot=(1.5, 1.0), cosine_falloff=True)


def sunny(stage):
    solid_shapes(stage)
    stage.add(leaves(300, 0.2, seed=76))
    irradiance = (0.6 * np.pi / ALBEDO,) * 3
    stage.scene.add_sun("sun", (1.0, -0.7, 1.5), np.radians(6), irradiance, stage.shadows)
    stage.scene.add_sun("sharp", (-0.8, -0.2, 1.5), 0.0, tuple(0.5 * e for e in irradiance), stage.shadows)


def overcast(stage):
    solid_shapes(stage)
    stage.scene.set_background((0.9 / ALBEDO,) * 3, lights=stage.shadows)


def garden(stage):
    """Leaves under a coloured sky with a bright disk; red is what the tests look at."""
    solid_shapes(stage)
    stage.add(leaves(300, 0.2, seed=77))
    y, x = np.mgrid[0:64, 0:128]
    sky = np.stack([0.3 + 0.2 * y / 64, 0.3 + 0.3 * y / 64, 0.3 + 0.7 * y / 64], axis=-1)
    sky[(x - 40) ** 2 + (y - 50) ** 2 < 5] = (60, 55, 45)
    sky = sky.astype(np.float32)
    stage.scene.set_background((0.8,) * 3, lights=stage.shadows, image=sky, local_from_world=rotation([0, 0, 1], 50))


def glowing_ball(stage):
    solid_shapes(stage)
    stage.glow(sphere([0, 0, 0], 0.5, 24), translation(2.0, -2.0, 3.0), 9.0)


def glowing_ribbon(stage):
    """A wavy strip, which shines to both sides and hides parts of itself, and a box."""
    solid_shapes(stage)
    x = np.linspace(-1.5, 1.5, 41)
    rail = np.stack([x, 0.5 * np.sin(4 * x), np.zeros(41)], axis=1)
    positions = np.concatenate([rail, rail + [0, 0, 0.4]])
    i = np.arange(40)
    triangles = np.concatenate([np.stack([i, i + 1, i + 42], 1), np.stack([i, i + 42, i + 41], 1)]).astype(np.int32)
    stage.glow((positions, triangles), translation(0.0, -1.0, 2.5), 3.0)
    stage.glow(box([-0.2, -0.2, -0.2], [0.2, 0.2, 0.2]), translation(-3.0, -1.5, 2.0) @ rotation([1, 2, 3], 40), 6.0)


def soft_boxes(stage):
    solid_shapes(stage)
    down = translation(1.5, -1.0, 4.0) @ rotation([1, 1, 0], 15)
    for shape, matrix, spread in (("RECTANGLE", down, 1.0), ("ELLIPSE", translation(-1.5, 1.0, 4.0), 2.0)):
        stage.scene.add_area_light("box", shape, matrix, (1.0, 0.7), (12.0,) * 3, stage.shadows, spread)


def lamps_seen(stage):
    """Lamps in the picture themselves, one before the other, and again in a mirror on the floor and on a wall."""
    for shape, matrix in (
        (floor(half=3.0, z=0.05), np.eye(4)),
        (floor(half=2.5), translation(-3.0, 3.0, 2.0) @ rotation([1, 0.4, 0], 90)),
    ):
        add(stage.scene, "mirror", shape, matrix, albedo=0.2, mirror=(0.7, 0.7, 0.7))
    solid_shapes(stage)
    role = pn.LuminaireRole(to_camera=True, in_mirrors=True)
    bright = (1.5,) * 3
    tilted = translation(0.5, 0.5, 2.6) @ rotation([1, 0.2, 0], -70) @ rotation([1, 0, 0], 180)
    stage.scene.add_area_light("seen", "ELLIPSE", tilted, (2.0, 1.2), bright, stage.shadows, role=role)
    stage.scene.add_point_light("ball", translation(-1.5, -1.5, 1.5), 0.4, (0.4,) * 3, stage.shadows, role=role)
    stage.scene.add_sun("sun", (-0.5, 1.0, 0.7), 0.2, (0.02,) * 3, stage.shadows, role=role)


SCENES = (open_floor, solid_objects, slanted_fence, wires, blinds, foliage, ellipse_and_square, many_luminaires,
          ball, spots, sunny, overcast, garden, glowing_ball, glowing_ribbon, soft_boxes, lamps_seen)  # fmt: skip


def make(function, shadows=True):
    stage = Stage(shadows)
    function(stage)
    return stage.scene
