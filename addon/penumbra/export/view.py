# SPDX-License-Identifier: GPL-3.0-or-later
"""What a 3D viewport looks through: its camera, and the part of the region that is rendered."""

from typing import NamedTuple

import numpy as np

from .camera import window_of
from .lens import Aperture, aperture_of


class View(NamedTuple):
    """Comparable by value: two equal views show the same picture of the same scene."""

    size: tuple[int, int]
    """(width, height) of the region in pixels"""
    border: tuple[int, int, int, int]
    """(x, y, width, height) of what is rendered, in the region's pixels from the bottom left"""
    kind: str
    world_from_camera: tuple[tuple[float, ...], ...]
    window: tuple[float, float, float, float]
    clip: tuple[float, float]
    aperture: Aperture | None

    @property
    def camera(self) -> tuple:
        """The arguments of the native scene's set_camera."""
        return self.kind, np.array(self.world_from_camera), self.window, self.clip, self.aperture


def clip_of(projection: np.ndarray, kind: str) -> tuple[float, float]:
    """(start, end) along the view axis, from a projection matrix in single precision; the end may be infinite."""
    scale, offset = projection[2, 2], projection[2, 3]
    with np.errstate(divide="ignore"):
        if kind == "PERSPECTIVE":
            start, end = offset / (scale - 1), offset / (scale + 1)
        else:
            start, end = (offset + 1) / scale, (offset - 1) / scale
    return float(start), float(end if end > start else np.inf)


def pixels_between(corners: np.ndarray, size: tuple[int, int]) -> tuple[int, int, int, int]:
    """(x, y, width, height) of the pixels in a rectangle, clipped to the region; at least one, wherever it lies.

    corners: (2, 2), the low and the high one in 0 ... 1.
    """
    low, high = np.clip(np.rint(corners * size), 0, size).astype(int)
    low = np.minimum(low, np.array(size) - 1)
    width, height = np.maximum(high - low, 1)
    return int(low[0]), int(low[1]), int(width), int(height)


def camera_frame(camera_object, scene, projection: np.ndarray) -> np.ndarray:
    """(2, 2): the low and high corner of the camera's frame in the region, which is 0 ... 1."""
    corners = np.array([(*corner, 1.0) for corner in camera_object.data.view_frame(scene=scene)]) @ projection.T
    placed = corners[:, :2] / corners[:, 3:] / 2 + 0.5
    return np.array([placed.min(axis=0), placed.max(axis=0)])


def camera_of(space, region_data, scene):
    """The camera that a view looks through; None for a view of its own."""
    camera = space.camera or scene.camera
    is_camera = region_data.view_perspective == "CAMERA" and camera is not None and camera.type == "CAMERA"
    return camera if is_camera else None


def border_of(space, region_data, scene, size: tuple[int, int], projection: np.ndarray) -> tuple[int, int, int, int]:
    """The part of the region that is rendered: the scene's border in the camera's frame, the view's own, or all."""
    camera = camera_of(space, region_data, scene)
    if camera:
        if not scene.render.use_border:
            return 0, 0, *size
        render, (low, high) = scene.render, camera_frame(camera, scene, projection)
        border = np.array([(render.border_min_x, render.border_min_y), (render.border_max_x, render.border_max_y)])
        return pixels_between(low + border * (high - low), size)
    if not space.use_render_border:
        return 0, 0, *size
    corners = [(space.render_border_min_x, space.render_border_min_y),
               (space.render_border_max_x, space.render_border_max_y)]  # fmt: skip
    return pixels_between(np.array(corners), size)


def view_of(space, region, region_data, scene) -> View:
    """The view of a region with a 3D view. Zoom, offset and shift of a camera view are in Blender's own projection.

    ValueError where there is nothing to see.
    """
    projection = np.array(region_data.window_matrix, dtype=np.float64)
    kind = "PERSPECTIVE" if projection[3, 3] == 0 else "ORTHOGRAPHIC"
    size = region.width, region.height
    world_from_camera = np.array(region_data.view_matrix.inverted(), dtype=np.float64)
    start, end = clip_of(projection, kind)
    if start < 0:  # an orthographic view looks both ways from its centre, a ray only ahead
        world_from_camera[:3, 3] -= start * world_from_camera[:3, 2]
        start, end = 0.0, end - start
    camera = camera_of(space, region_data, scene)
    return View(
        size,
        border_of(space, region_data, scene, size, projection),
        kind,
        tuple(map(tuple, world_from_camera.tolist())),
        tuple(map(float, window_of(projection, kind))),
        (start, end),
        aperture_of(camera) if camera else None,
    )
