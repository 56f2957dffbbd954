# SPDX-License-Identifier: GPL-3.0-or-later
"""The camera, the picture's size and its border."""

import numpy as np

from ..notes import Notes
from .errors import ExportError
from .lens import aperture_of

KINDS = {"PERSP": "PERSPECTIVE", "ORTHO": "ORTHOGRAPHIC"}


def frame_size(scene) -> tuple[int, int]:
    """(width, height) of the full frame in pixels, resolution percentage applied the way Blender does."""
    render = scene.render
    scale = render.resolution_percentage
    return render.resolution_x * scale // 100, render.resolution_y * scale // 100


def render_region(scene) -> tuple[int, int, int, int]:
    """(x, y, width, height) of what is rendered, in full-frame pixels from the bottom left: the border or everything.

    Blender multiplies in single precision and cuts off, so this does too.
    """
    render = scene.render
    width, height = frame_size(scene)
    if not render.use_border:
        return 0, 0, width, height
    left, right = (int(np.float32(b) * np.float32(width)) for b in (render.border_min_x, render.border_max_x))
    bottom, top = (int(np.float32(b) * np.float32(height)) for b in (render.border_min_y, render.border_max_y))
    return left, bottom, right - left, top - bottom


def window_of(projection: np.ndarray, kind: str) -> tuple[float, float, float, float]:
    """(left, right, bottom, top) of the frame, from a projection matrix (clip space from camera space, 4 x 4).

    "PERSPECTIVE": in the plane z = -1; "ORTHOGRAPHIC": in world units.
    """
    offset = -projection[:2, 2] if kind == "PERSPECTIVE" else projection[:2, 3]
    scale = projection[0, 0], projection[1, 1]
    (left, right), (bottom, top) = (((-1 - o) / s, (1 - o) / s) for o, s in zip(offset, scale, strict=True))
    return left, right, bottom, top


def pose_of(camera, depsgraph) -> tuple[np.ndarray, tuple[float, float, float, float]]:
    """(world_from_camera, window) of an evaluated camera; ExportError naming it where there is nothing to see."""
    scene, name = depsgraph.scene_eval, f"camera {camera.name!r}"
    width, height = frame_size(scene)
    projection = camera.calc_matrix_camera(
        depsgraph, x=width, y=height, scale_x=scene.render.pixel_aspect_x, scale_y=scene.render.pixel_aspect_y
    )
    world_from_camera = np.array(camera.matrix_world, dtype=np.float64)
    lengths = np.linalg.norm(world_from_camera[:3, :3], axis=0)
    if not np.isfinite(world_from_camera).all():
        raise ExportError(f"{name}: its position or rotation is not a finite number")
    if not lengths.all():
        raise ExportError(f"{name}: its scale is zero")
    world_from_camera[:3, :3] /= lengths
    with np.errstate(all="ignore"):
        window = window_of(np.array(projection, dtype=np.float64), KINDS.get(camera.data.type, "PERSPECTIVE"))
    left, right, bottom, top = window
    if not (np.isfinite(window).all() and left < right and bottom < top):
        raise ExportError(f"{name}: its field of view, scale or shift leaves nothing to see")
    return world_from_camera, window


def export(native_scene, depsgraph, camera_object, notes: Notes, motion=None) -> None:
    """Sets the native scene's camera; ExportError naming the camera if it cannot be rendered with."""
    scene = depsgraph.scene_eval
    camera = camera_object or scene.camera
    if camera is None:
        raise ExportError(f"scene {scene.name!r} has no camera")
    name = f"camera {camera.name!r}"
    if camera.type != "CAMERA":
        raise ExportError(f"{name} is no camera but an object of type {camera.type}")
    if scene.render.use_multiview:
        raise ExportError(f"{name}: stereoscopy (multi-view) is not supported yet")
    data = camera.data
    if data.type not in KINDS:
        raise ExportError(f"{name}: {data.type.lower()} cameras are not supported, only perspective and orthographic")
    clip = data.clip_start, data.clip_end
    if not 0 <= clip[0] < clip[1]:
        raise ExportError(f"{name}: clip start {clip[0]:g} m is not below clip end {clip[1]:g} m")
    world_from_camera, window = pose_of(camera, depsgraph)
    aperture = aperture_of(camera)
    if aperture and scene.penumbra.pixel_samples == 1:
        notes.add(f"{name}: with one ray a pixel (pixel_samples 1) there is no depth of field: it is a pinhole")
        aperture = None
    moved = {}
    if motion:
        poses, windows = zip(*motion.camera, strict=True) if motion.camera else ((), ())
        moved = {"motion": list(poses), "window_motion": list(windows), "shutter": motion.shutter}
    native_scene.set_camera(KINDS[data.type], world_from_camera, window, clip, aperture, **moved)
