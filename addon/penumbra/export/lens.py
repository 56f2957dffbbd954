# SPDX-License-Identifier: GPL-3.0-or-later
"""Depth of field: a camera's settings as the opening of a thin lens, by Cycles' rules."""

import numpy as np

from .. import compat
from .errors import ExportError

Aperture = tuple[float, float, int, float, float]
"""(radius in metres, focus distance in metres, blades, rotation in radians, ratio): an argument of set_camera."""

SMALLEST_F_STOP = 1e-5
NEAREST_FOCUS = 1e-5
"""Metres."""


def focus_distance(camera) -> float:
    """Metres along the camera's view axis: to the focus object, or its bone, else as it is set."""
    dof = camera.data.dof
    target = dof.focus_object
    if target is None:
        return dof.focus_distance
    place = target.matrix_world
    if target.pose and dof.focus_subtarget in target.pose.bones:
        place = place @ target.pose.bones[dof.focus_subtarget].matrix
    axis = np.array(camera.matrix_world.col[2][:3], dtype=np.float64)
    between = np.array(camera.matrix_world.translation, dtype=np.float64) - np.array(place.translation)
    return abs(float(between @ axis / np.linalg.norm(axis)))


def aperture_of(camera) -> Aperture | None:
    """Of an evaluated camera object; None for a pinhole. ExportError naming the camera if its focus is nowhere.

    As in Cycles, an orthographic camera's lens has a focal length of 1 m; its place depends on the version.
    """
    dof = camera.data.dof
    if not dof.use_dof:
        return None
    focal_length = 1.0 if camera.data.type == "ORTHO" else camera.data.lens * 1e-3
    radius = focal_length / (2 * max(dof.aperture_fstop, SMALLEST_F_STOP))
    numbers = radius, focus_distance(camera), dof.aperture_rotation, dof.aperture_ratio
    if not np.isfinite(numbers).all():
        raise ExportError(f"camera {camera.name!r}: its focus distance, f-stop, rotation or ratio is not finite")
    distance = max(numbers[1], NEAREST_FOCUS)
    if camera.data.type == "ORTHO" and compat.ORTHOGRAPHIC_LENS_AT_CLIP_START:  # as seen from the camera's own plane
        radius *= (distance + camera.data.clip_start) / distance
        distance += camera.data.clip_start
    return radius, distance, dof.aperture_blades, dof.aperture_rotation, dof.aperture_ratio
