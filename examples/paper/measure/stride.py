# SPDX-License-Identifier: GPL-3.0-or-later
"""Fig. 2's warning in a picture: a careless use that takes every other Sobol' point.

The engine itself never strides, so this one picture is made outside it: its own points, its own surface positions and
normals from the passes, eq. (4) and the sphere's shadow in NumPy. The careful version, made the same way, is compared
with the engine's own picture and has to agree.
"""

import bpy
import metrics
import numpy as np
import references
import scenes
from engine import ExportedScene, Picture, pn
from methods import SOBOL
from sizes import Size
from tables import Data

POINTS = 16


def measure(data: Data, size: Size) -> None:
    scene = scenes.sphere_on_ground(size.picture)
    exported = ExportedScene(scene)
    passes = ("Combined", "Position", "Normal")
    engine = exported.render(passes, stop_rule="FIXED", light_samples=POINTS, **SOBOL.settings)
    reference = references.converged(scene, size.reference_points).display
    points = pn.sample_points("SOBOL", 2 * POINTS)
    columns = np.arange(size.picture[0])
    careful = picture_from_points(engine, np.broadcast_to(points[:POINTS], (len(columns), POINTS, 2)))
    striding = picture_from_points(engine, np.stack([points[x % 2 :: 2] for x in columns]))
    halved = picture_from_points(engine, np.broadcast_to(points[1::2], (len(columns), POINTS, 2)))
    data.write_pictures("stride", careful=careful, striding=striding, halved=halved, reference=reference)
    data.write("stride_errors", [
        {"picture": name, "rmse": metrics.rmse(picture, reference),
         "rmse_against_engine": metrics.rmse(picture, engine.display)}
        for name, picture in (("careful", careful), ("striding", striding), ("halved", halved))
    ])  # fmt: skip


def picture_from_points(engine: Picture, points: np.ndarray) -> np.ndarray:
    """Eq. (4) with `points` (width, N, 2), those of each column of pixels, on the sphere's scene: (h, w, 3)."""
    positions, normals = (engine.passes[name].astype(np.float64) for name in ("Position", "Normal"))
    corners = references.luminaire_corners()
    edges = corners[1] - corners[0], corners[3] - corners[0]
    area = np.linalg.norm(np.cross(*edges))
    total = np.zeros(positions.shape[:2])
    for i in range(points.shape[1]):
        u, v = points[:, i, :, None].transpose(1, 0, 2)
        d = (corners[0] + u * edges[0] + v * edges[1]) - positions
        squared = np.sum(d * d, axis=-1)
        cosine = np.maximum(np.sum(d * normals, axis=-1), 0)
        total += np.maximum(d[..., 2], 0) * cosine / squared**2 * ~hidden_by_sphere(positions, d)
    albedo = np.where(np.abs(positions[..., 2]) < 1e-4, 0.8, 0.7)
    radiance = references.luminaire_radiance(area) * 2.0**bpy.context.scene.view_settings.exposure
    return np.repeat((total * albedo * radiance * area / np.pi / points.shape[1])[..., None], 3, axis=-1)


def hidden_by_sphere(origins: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """Whether the scene's sphere lies between points (..., 3) and points + directions."""
    radius = scenes.SPHERE_RADIUS
    o = origins - (0.0, 0.0, radius)
    a, b = np.sum(directions * directions, axis=-1), np.sum(o * directions, axis=-1)
    discriminant = b * b - a * (np.sum(o * o, axis=-1) - radius**2)
    nearest = (-b - np.sqrt(np.maximum(discriminant, 0))) / a
    return (discriminant > 0) & (nearest > 1e-3) & (nearest < 1)
