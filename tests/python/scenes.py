# SPDX-License-Identifier: GPL-3.0-or-later
"""Small scenes for the tests: shapes as arrays, transforms as 4 x 4 matrices, and a render in one call."""

from dataclasses import dataclass

import numpy as np
import penumbra_native as pn

ALL_PASSES = ["Combined", "Depth", "Normal", "Position", "Light Samples", "Error Estimate"]


@dataclass
class Picture:
    """Passes as float64 (height, width, channels) arrays, row 0 = bottom, and the statistics."""

    passes: dict
    statistics: dict

    @property
    def red(self):
        return self.passes["Combined"][..., 0]

    @property
    def position(self):
        return self.passes["Position"]

    @property
    def light_samples(self):
        return self.passes["Light Samples"][..., 0]


def render(scene, width=16, height=None, **settings):
    """Renders everything; `settings` as for penumbra_native.Render. Returns a Picture."""
    settings = {"width": width, "height": height or width, "passes": ALL_PASSES, "threads": 2, **settings}
    job = pn.Render(scene, settings)
    job.start()
    while not job.done:
        job.wait(1.0)
    job.finish()
    return Picture({name: np.asarray(a, float) for name, a in job.passes().items()}, job.statistics())


# Transforms, world_from_local.


def translation(x, y, z):
    m = np.eye(4)
    m[:3, 3] = x, y, z
    return m


def scaling(x, y, z):
    return np.diag([x, y, z, 1.0])


def rotation(axis, degrees):
    """About a vector through the origin (Rodrigues)."""
    k = np.asarray(axis, float) / np.linalg.norm(axis)
    cross = np.array([[0, -k[2], k[1]], [k[2], 0, -k[0]], [-k[1], k[0], 0]])
    a = np.radians(degrees)
    m = np.eye(4)
    m[:3, :3] += np.sin(a) * cross + (1 - np.cos(a)) * cross @ cross
    return m


def apply(matrix, points):
    return np.asarray(points, float) @ matrix[:3, :3].T + matrix[:3, 3]


# Shapes: (positions (V, 3) float64, triangles (T, 3) int32).


def parallelogram(corner, u, v, columns=1, rows=1):
    """A flat grid of columns x rows cells of two triangles; its normal is u x v."""
    s, t = np.meshgrid(np.linspace(0, 1, columns + 1), np.linspace(0, 1, rows + 1))
    positions = (
        np.asarray(corner, float) + s.reshape(-1, 1) * np.asarray(u, float) + t.reshape(-1, 1) * np.asarray(v, float)
    )
    i = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).ravel()
    a, b, c, d = i, i + 1, i + columns + 2, i + columns + 1
    return positions, np.stack([a, b, c, a, c, d], axis=1).reshape(-1, 3).astype(np.int32)


def floor(half=4.0, z=0.0, columns=1):
    return parallelogram([-half, -half, z], [2 * half, 0, 0], [0, 2 * half, 0], columns, columns)


def box(low, high):
    """A closed box, faces outward."""
    low, high = np.asarray(low, float), np.asarray(high, float)
    positions = np.array([[(low, high)[k >> axis & 1][axis] for axis in range(3)] for k in range(8)])
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    return positions, np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))], np.int32)


def sphere(centre, radius, segments=16):
    """Latitude and longitude, faces outward; triangles at the poles are not degenerate."""
    rings = segments // 2
    theta = np.pi * np.arange(1, rings) / rings
    phi = 2 * np.pi * np.arange(segments) / segments
    ring = np.stack(
        np.broadcast_arrays(
            np.sin(theta)[:, None] * np.cos(phi), np.sin(theta)[:, None] * np.sin(phi), np.cos(theta)[:, None]
        ),
        axis=-1,
    ).reshape(-1, 3)
    positions = np.concatenate([ring, [[0, 0, 1], [0, 0, -1]]]) * radius + np.asarray(centre, float)

    def at(i, k):
        return i * segments + k % segments

    north, south = len(ring), len(ring) + 1
    triangles = [(north, at(0, k), at(0, k + 1)) for k in range(segments)]
    triangles += [(south, at(rings - 2, k + 1), at(rings - 2, k)) for k in range(segments)]
    for i in range(rings - 2):
        for k in range(segments):
            triangles += [(at(i, k), at(i + 1, k), at(i + 1, k + 1)), (at(i, k), at(i + 1, k + 1), at(i, k + 1))]
    return positions, np.array(triangles, np.int32)


# Scenes.


def add(scene, name, shape, matrix=None, albedo=0.5, **material):
    """One mesh, used once, of one material; albedo: a number, or r, g, b. Returns the mesh's number."""
    number = scene.add_material(name, tuple(np.broadcast_to(albedo, 3).tolist()), **material)
    mesh = scene.add_mesh(name, *shape)
    scene.add_instance(name, mesh, np.eye(4) if matrix is None else matrix, [number])
    return mesh


def light_above(z=2.0, x=0.0, y=0.0):
    """A luminaire's transform: facing straight down."""
    return translation(x, y, z)


def look_down(scene, half=2.0, z=50.0, matrix=None):
    """Orthographic from above (of what `matrix` places): `half` to each side of the origin."""
    m = translation(0, 0, z)
    scene.set_camera("ORTHOGRAPHIC", m if matrix is None else matrix @ m, (-half, half, -half, half), (1e-3 * z, 2 * z))


def lit_floor(radiance=(3.0, 3.0, 3.0), size=(1.0, 1.0), light=None, shape="RECTANGLE", albedo=0.5, half=2.0):
    """The simplest scene: a floor, a luminaire 2 above it, a camera from above."""
    scene = pn.Scene()
    add(scene, "floor", floor(), albedo=albedo)
    scene.add_area_light("key", shape, light_above() if light is None else light, size, radiance)
    look_down(scene, half)
    return scene
