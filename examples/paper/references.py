# SPDX-License-Identifier: GPL-3.0-or-later
"""What the pictures are compared with: closed forms where nothing occludes, converged pictures elsewhere."""

from typing import NamedTuple

import bpy
import numpy as np
import scenes
from engine import ExportedScene, Picture, penumbra
from methods import OWEN_SOBOL

LIT, PENUMBRA, UMBRA = 0, 1, 2
FIRST_POINTS = 1024
TILE = 16
SEEDS = (1001, 1002)
"""Not the seed of any picture that is judged."""


class Reference(NamedTuple):
    """display, unshadowed: (height, width, 3) in display units; classes: LIT, PENUMBRA, UMBRA of each pixel."""

    display: np.ndarray
    unshadowed: np.ndarray
    classes: np.ndarray
    own_error: float
    """Its root mean square error over the penumbra, estimated from its two halves"""
    positions: np.ndarray
    """(height, width, 3) of what each pixel sees, in the world"""

    @property
    def visible(self) -> np.ndarray:
        """(height, width): the share of the unshadowed light that arrives, 0 where there would be none."""
        full = self.unshadowed.sum(axis=-1)
        return np.divide(self.display.sum(axis=-1), full, out=np.zeros_like(full), where=full > 0)

    @property
    def half_seen_floor(self) -> np.ndarray:
        """(height, width): pixels of the floor where between 10 and 90 % of the light arrive."""
        return (np.abs(self.positions[..., 2]) < 1e-4) & (self.visible > 0.1) & (self.visible < 0.9)


def luminaire_corners() -> np.ndarray:
    """(4, 3) corners of the scene's rectangular luminaire in order, in the world."""
    luminaire = bpy.data.objects["Luminaire"]
    data, matrix = luminaire.data, np.array(luminaire.matrix_world)
    x = data.size / 2
    y = (data.size_y if data.shape == "RECTANGLE" else data.size) / 2
    local = np.array([[-x, -y, 0, 1], [x, -y, 0, 1], [x, y, 0, 1], [-x, y, 0, 1]])
    return (local @ matrix.T)[:, :3]


def luminaire_radiance(area: float) -> float:
    """L_e of the scene's luminaire, by the add-on's radiometry."""
    return penumbra.export.luminaires.area_radiance(bpy.data.lights["Luminaire"].energy, (1.0, 1.0, 1.0), area)[0]


def lambert(corners: np.ndarray, points: np.ndarray, normal=(0.0, 0.0, 1.0)) -> np.ndarray:
    """Form factor E / (pi L_e) of a polygon that lies above the horizon of the points (..., 3): Lambert 1760."""
    total = np.zeros(points.shape[:-1])
    for begin, end in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        a, b = begin - points, end - points
        cross = np.cross(a, end - begin)
        size = np.linalg.norm(cross, axis=-1)
        total += np.arctan2(size, np.sum(a * b, axis=-1)) * (cross @ np.asarray(normal)) / size
    return np.abs(total) / (2 * np.pi)


def closed_form(scene, albedo: float = 0.8) -> Reference:
    """The bare ground under the square luminaire: albedo x L_e x F, exact but for the floats of the positions."""
    positions = _positions(ExportedScene(scene))
    corners = luminaire_corners()
    area = np.linalg.norm(np.cross(corners[1] - corners[0], corners[3] - corners[0]))
    radiance = luminaire_radiance(area)
    form_factor = lambert(corners, positions)
    display = np.repeat((albedo * radiance * 2.0**scene.view_settings.exposure * form_factor)[..., None], 3, axis=-1)
    return Reference(display, display, np.zeros(display.shape[:2], int), 0.0, positions)


def converged(scene, points: int) -> Reference:
    """A converged picture: the exact same Owen-Sobol' points with and without shadows, so that a pixel is lit or in the
    umbra where all of them agree; the tiles that have a penumbra get 2 x `points` of them instead of FIRST_POINTS."""
    pair = [ExportedScene(scene), scenes.unshadowed(scene)]
    first = [_render(exported, FIRST_POINTS, SEEDS[0]) for exported in pair]
    halves = [[p.display for p in first] for _ in SEEDS]
    for region in _tiles(first):
        for half, seed in zip(halves, SEEDS, strict=True):
            for image, exported in zip(half, pair, strict=True):
                _paste(image, region, _render(exported, points, seed, region).display)
    shadowed, unshadowed = (np.mean([half[i] for half in halves], axis=0) for i in range(2))
    classes = np.where(shadowed.sum(-1) == 0, UMBRA, np.where(np.all(shadowed == unshadowed, -1), LIT, PENUMBRA))
    difference = (halves[0][0] - halves[1][0])[classes == PENUMBRA]
    return Reference(shadowed, unshadowed, classes, float(np.sqrt(np.mean(difference**2)) / 2), _positions(pair[0]))


def _positions(exported: ExportedScene) -> np.ndarray:
    picture = exported.render(("Position",), stop_rule="FIXED", light_samples=1)
    return picture.passes["Position"].astype(np.float64)


def _render(exported: ExportedScene, points: int, seed: int, region=None) -> Picture:
    where = {} if region is None else {"region": region}
    return exported.render(stop_rule="FIXED", light_samples=points, seed=seed, **OWEN_SOBOL.settings, **where)


def _tiles(first: list[Picture]):
    """(x, y, width, height) of the tiles where some but not all points see the luminaire."""
    shadowed, unshadowed = (picture.passes["Combined"][..., 1] for picture in first)
    mixed = (shadowed > 0) & (shadowed != unshadowed)
    height, width = mixed.shape
    for y in range(0, height, TILE):
        for x in range(0, width, TILE):
            if mixed[y : y + TILE, x : x + TILE].any():
                yield x, y, min(TILE, width - x), min(TILE, height - y)


def _paste(image: np.ndarray, region, block: np.ndarray) -> None:
    x, y, width, height = region
    image[y : y + height, x : x + width] = block
