# SPDX-License-Identifier: GPL-3.0-or-later
"""How far a picture is from the reference, in the words of the tolerance."""

import numpy as np


def pixel_errors(picture: np.ndarray, reference: np.ndarray, display_scale: float) -> np.ndarray:
    """(H, W) error of each pixel in display units: largest of r, g, b, relative to the reference above white.

    picture, reference: (H, W, 3) radiance; display_scale: 2 ^ exposure.
    """
    return weighted(picture.astype(np.float64) - reference, reference, display_scale)


def weighted(difference: np.ndarray, reference: np.ndarray, display_scale: float) -> np.ndarray:
    """(H, W): a difference (H, W, 3) of radiances as an error of `reference` in display units."""
    value = reference.max(axis=-1) * display_scale
    return np.abs(difference).max(axis=-1) * display_scale / np.maximum(value, 1.0)


def figures(errors: np.ndarray, tolerance: float) -> dict[str, float]:
    """The columns of the table that come from a picture's pixel errors."""
    p95, p99 = np.quantile(errors, (0.95, 0.99))
    return {
        "rmse": float(np.sqrt(np.mean(errors**2))),
        "mean_absolute": float(errors.mean()),
        "p95": float(p95),
        "p99": float(p99),
        "max": float(errors.max()),
        "tolerance": tolerance,
        "share_within_tolerance": float(np.mean(errors <= tolerance)),
    }


def seconds_for_error(rows: list[dict], p99: float) -> float | None:
    """What a family of runs, roughest first, needs for a 99th-percentile error: interpolated between logarithms.

    Infinite if no run is good enough, None if the first one already is.
    """
    if rows[0]["p99"] <= p99:
        return None
    for before, after in zip(rows, rows[1:], strict=False):
        if after["p99"] <= p99:
            share = np.log(before["p99"] / p99) / np.log(before["p99"] / max(after["p99"], 1e-30))
            return float(before["seconds"] * (after["seconds"] / before["seconds"]) ** share)
    return float("inf")
