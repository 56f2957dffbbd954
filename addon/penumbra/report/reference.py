# SPDX-License-Identifier: GPL-3.0-or-later
"""The reference: fixed Owen-scrambled Sobol' points, as many as make its own error small enough.

Its error is estimated from two pictures a and b of different seeds: the reference is their mean, whose error is
distributed as (a - b) / 2 is.
"""

import math
from collections.abc import Callable

import numpy as np

from .measure import weighted
from .study import Reference, say

SMALLER = 10.0
"""The reference's error is so many times below the smallest tolerance shown."""

FIRST_POINTS, MOST_POINTS = 1024, 2**20
POINTS_A_RAY = 16
"""Light points at each primary ray of an antialiased reference; the rest are primary rays."""
MOST_RAYS = 4e9
"""Shadow rays of one of the two pictures: some minutes on two cores."""
DECAY = 0.75
"""The error of these points falls as N ^ -0.75 across a shadow's edge (Owen, scrambled nets on discontinuities)."""
SEEDS = 0x5EED0001, 0x5EED0002


def _settings(own: dict, points: int, seed: int) -> dict:
    """The reference's settings; `points`: light points of a pixel and luminaire, a power of two."""
    antialiased = own["pixel_samples"] > 1
    rays = max(points // POINTS_A_RAY, 2) if antialiased else 1
    return own | {
        "stop_rule": "FIXED",
        "sampler": "OWEN_SOBOL",
        "sample_reuse": "SCRAMBLED",
        "pixel_samples": rays,
        "light_samples": points // rays,
        "seed": (own["seed"] + seed) % 2**31,
        "passes": ["Combined"],
    }


def converge(render: Callable, own: dict, smallest_tolerance: float) -> Reference:
    """Adds points until the reference is good for `smallest_tolerance`, or too many rays would be needed.

    render(settings) -> (passes, statistics).
    """
    scale, target = 2.0 ** own["exposure"], smallest_tolerance / SMALLER
    points = FIRST_POINTS
    while True:
        used, pictures = [_settings(own, points, seed) for seed in SEEDS], []
        for settings in used:
            passes, statistics = render(settings)
            pictures.append(passes["Combined"][..., :3].astype(np.float64))
        mean = (pictures[0] + pictures[1]) / 2
        errors = weighted((pictures[0] - pictures[1]) / 2, mean, scale)
        p99, rmse = float(np.quantile(errors, 0.99)), float(np.sqrt(np.mean(errors**2)))
        each = f"{used[0]['pixel_samples']} x {used[0]['light_samples']} points"
        say(f"reference of 2 x {each}: 99 % of its pixels within {p99:.2g} (RMSE {rmse:.2g}), wanted {target:.2g}")
        wanted = points * (p99 / target) ** (1 / DECAY)
        more = 2 ** math.ceil(math.log2(max(wanted, 2 * points)))
        rays = statistics["shadow_rays"] + statistics["primary_rays"]
        if p99 <= target or more > MOST_POINTS or rays * more / points > MOST_RAYS:
            seeds = " and ".join(str(settings["seed"]) for settings in used)
            description = f"FIXED, OWEN_SOBOL SCRAMBLED, {each} a pixel and luminaire; the mean of the seeds {seeds}"
            return Reference(mean, p99, rmse, description, used)
        points = more
