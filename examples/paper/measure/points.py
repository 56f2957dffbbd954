# SPDX-License-Identifier: GPL-3.0-or-later
"""Fig. 1: the first points of each sequence. Fig. 2: even and odd Sobol' points. And what a point costs."""

import time

import methods
import numpy as np
import scenes
from engine import pn
from methods import HALTON, OWEN_SOBOL, PRS, SOBOL, SPRS, Method
from sizes import Size
from tables import Data, Row

FIRST = 16
DISCREPANCY_POINTS = (16, 64, 256)
SHOWN = (PRS, SPRS, SOBOL, HALTON, OWEN_SOBOL)
SOBOL_POINTS = 512
TIMED_POINTS, TIMED_IN_PICTURE = 1 << 14, 1024


def measure(data: Data, size: Size) -> None:
    data.write("fig1_points", first_points())
    data.write("fig1_discrepancies", [
        {"sampler": sampler, "points": count, "discrepancy": discrepancy(pn.sample_points(sampler, count, reuse))}
        for count in DISCREPANCY_POINTS for sampler, reuse in SHOWN
    ])  # fmt: skip
    points = pn.sample_points("SOBOL", SOBOL_POINTS)  # begins at index 1, as the book does
    data.write("fig2_points", [
        {"index": i + 1, "parity": "odd" if i % 2 == 0 else "even", "x": float(x), "y": float(y)}
        for i, (x, y) in enumerate(points)
    ])  # fmt: skip
    data.write("cost_of_a_point", costs(size))


def first_points() -> list[Row]:
    rows = []
    for sampler, reuse in SHOWN:
        for i, (x, y) in enumerate(pn.sample_points(sampler, FIRST, reuse)):
            rows.append({"sampler": sampler, "number": i + 1, "x": float(x), "y": float(y)})
    return rows


def discrepancy(points: np.ndarray) -> float:
    """L2 star discrepancy of (N, 2) points: root mean square over all boxes [0, a) x [0, b) of the share of points
    inside minus the area (Warnock 1972)."""
    n = len(points)
    largest = np.maximum(points[:, None, :], points[None, :, :])
    squared = 1 / 9 - np.prod(1 - points**2, axis=1).sum() / (2 * n) + np.prod(1 - largest, axis=2).sum() / n**2
    return float(np.sqrt(squared))


def costs(size: Size) -> list[Row]:
    """Nanoseconds a point: made one after the other, and in a picture whose luminaire casts no shadow, so that a point
    costs its own making and its share of eq. (4) but no ray. The least of several rounds."""
    exported = scenes.unshadowed(scenes.sphere_on_ground((64, 48)))
    rows = []
    for method in methods.ALL:
        made, shaded = [], []
        for _ in range(size.timing_rounds):
            made.append(seconds_to_make(method) / TIMED_POINTS)
            picture = exported.render(stop_rule="FIXED", light_samples=TIMED_IN_PICTURE, threads=1, **method.settings)
            shaded.append(picture.seconds / picture.statistics["light_points"])
        rows.append({"sampler": method.sampler, "reuse": method.reuse, "made_ns": float(np.min(made) * 1e9),
                     "in_a_picture_ns": float(np.min(shaded) * 1e9)})  # fmt: skip
    return rows


def seconds_to_make(method: Method) -> float:
    begin = time.process_time()
    pn.sample_points(method.sampler, TIMED_POINTS, method.reuse)
    return time.process_time() - begin
