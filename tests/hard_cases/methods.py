# SPDX-License-Identifier: GPL-3.0-or-later
"""Every valid combination of sampler, reuse and stop rule, and pictures whose points are known in float64."""

import numpy as np
import penumbra_native as pn
from scenes import add, floor, render

UP = np.array([0.0, 0.0, 1.0])

BOUNDED = {"stop_rule": "BOUNDED"}
ANTIALIASED = {"stop_rule": "BOUNDED", "pixel_samples": 2}
FIXED = {"stop_rule": "FIXED", "light_samples": 1024}
"""The default, the default with antialiasing, and plain points."""

SEQUENCES = [("PRS", "SCRAMBLED"), ("SPRS", "SCRAMBLED")] + [
    (sampler, reuse)
    for sampler in ("SOBOL", "HALTON", "OWEN_SOBOL")
    for reuse in ("SAME", "CONTINUED", "ROTATED", "SCRAMBLED")
]
COMBINATIONS = {"BOUNDED": BOUNDED, "BOUNDED antialiased": ANTIALIASED} | {
    f"{rule} {sampler} {reuse}": {"stop_rule": rule, "sampler": sampler, "sample_reuse": reuse}
    for rule in ("FIXED", "PAPER", "VARIANCE")
    for sampler, reuse in SEQUENCES
    if sampler != "SPRS" or rule == "FIXED"
}


def patch(scale=1.0, albedo=0.5, **material):
    """A scene of a floor, 2 x scale to each side, seen from 0.1 x scale above: under whatever hangs higher."""
    scene = pn.Scene()
    add(scene, "floor", floor(2 * scale), albedo=albedo, **material)
    return scene


def look_at(scene, x, y, half, height):
    """Orthographic from straight above the floor's point (x, y)."""
    camera = np.eye(4)
    camera[:3, 3] = x, y, height
    scene.set_camera("ORTHOGRAPHIC", camera, (-half, half, -half, half), (0.01 * height, 2 * height))


def centres(x, y, half, n):
    """The floor points (n, n, 3) that the pixels' centres of look_at() see, exact in float64."""
    c = ((np.arange(n) + 0.5) / n * 2 - 1) * half
    return np.stack(np.broadcast_arrays(x + c[None, :], y + c[:, None], 0.0), axis=-1)


def red(scene, n=8, **settings):
    return render(scene, n, **settings).red


def relative(value, exact):
    """Largest |value / exact - 1|."""
    return float(np.abs(value / exact - 1).max())
