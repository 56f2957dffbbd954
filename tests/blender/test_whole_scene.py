# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene with many features at once beside Cycles' picture of it (see whole_scene.py for what is in it).

Centre rays. Tolerances: each channel's mean within 1 % (Principled's share; seen in Blender 3.4: 0.2 %) and four of
Cycles' noise; the root mean square of the difference within 1.3 of Cycles' noise and half of BOUNDED's tolerance (seen:
0.008, 4.6 % of the mean, at a noise of 0.002; most of it on the ground below leaves whose holes are cut by alpha).
"""

import numpy as np
import whole_scene
from helpers import render_pixels, use_cycles_as_reference
from penumbra import statistics

TOLERANCE = 0.02


def picture_of_cycles(scene, seed: int) -> np.ndarray:
    use_cycles_as_reference(scene, 128)
    scene.cycles.seed = seed
    return render_pixels(scene, "CYCLES")["Combined"][..., :3].astype(float)


def test_as_in_cycles(scene):
    whole_scene.build(scene)
    scene.cycles_curves.shape = "RIBBONS"
    scene.render.resolution_x, scene.render.resolution_y = 64, 48
    scene.penumbra.error_tolerance, scene.penumbra.pixel_samples = TOLERANCE, 1
    ours = render_pixels(scene, "PENUMBRA")["Combined"][..., :3].astype(float)
    assert statistics.last_render["warnings"] == []  # nothing is left out
    first, second = picture_of_cycles(scene, 0), picture_of_cycles(scene, 1)
    noise, theirs = (first - second) / 2, (first + second) / 2
    difference = ours - theirs
    of_mean = np.sqrt((noise**2).mean((0, 1)) / noise[..., 0].size)
    assert (np.abs(difference.mean((0, 1))) < 0.01 * theirs.mean((0, 1)) + 4 * of_mean).all()
    assert np.sqrt((difference**2).mean()) < 1.3 * np.sqrt((noise**2).mean()) + TOLERANCE / 2
