# SPDX-License-Identifier: GPL-3.0-or-later
"""What a report is made of: the reference, and one row and one picture for each run."""

from dataclasses import dataclass, field
from time import perf_counter, process_time

import numpy as np

ENOUGH_SECONDS, MOST_REPEATS = 1.0, 3
"""Short runs are repeated, until these are reached, and the fastest counts: the first one pays for cold memory."""


class Cancelled(RuntimeError):
    """The user pressed Esc or Ctrl-C."""

    def __init__(self) -> None:
        super().__init__("the report was cancelled")


@dataclass
class Reference:
    """The mean of two converged pictures of different seeds."""

    colour: np.ndarray
    """(H, W, 3) float64 radiance"""
    error_p99: float
    """Its own error in display units, from the half difference of the two: 99 % of the pixels are below."""
    error_rmse: float
    description: str
    settings: list[dict]
    """The native settings of the two."""


@dataclass
class Picture:
    """What is shown of one run."""

    row: dict
    errors: np.ndarray
    """(H, W) display units"""
    samples: np.ndarray | None
    """(H, W) light points, where the renderer tells them"""


@dataclass
class Study:
    """Everything measured; `rows` are the lines of the table and of the CSV file."""

    own: dict
    """The user's settings, as the native renderer gets them."""
    display_scale: float
    reference: Reference
    facts: list[tuple[str, str]]
    """(name, text): scene, machine, versions"""
    rows: list[dict] = field(default_factory=list)
    pictures: list[Picture] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    has_mirrors: bool = False

    def add(self, row: dict, errors: np.ndarray, samples: np.ndarray | None) -> None:
        self.rows.append(row)
        self.pictures.append(Picture(row, errors, samples))
        say(f"{row['family']:32} {row['setting']:14} {row['seconds']:8.3f} s   99 % below {row['p99']:.2g},"
            f" {100 * row['share_within_tolerance']:.2f} % within {row['tolerance']:g}")  # fmt: skip

    def families(self) -> dict[str, list[dict]]:
        """The rows by family, in the order they came."""
        grouped: dict[str, list[dict]] = {}
        for row in self.rows:
            grouped.setdefault(row["family"], []).append(row)
        return grouped


def say(text: str) -> None:
    print(f"Penumbra report: {text}", flush=True)


def fastest(render):
    """(result, wall seconds, CPU seconds of all threads) of the fastest of a few calls of render()."""
    best, total = None, 0.0
    for _ in range(MOST_REPEATS):
        wall, cpu = perf_counter(), process_time()
        result = render()
        wall, cpu = perf_counter() - wall, process_time() - cpu
        if best is None or wall < best[1]:
            best = result, wall, cpu
        total += wall
        if total >= ENOUGH_SECONDS:
            break
    return best
