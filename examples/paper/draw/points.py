# SPDX-License-Identifier: GPL-3.0-or-later
"""Fig. 1 and 2: points in the unit square."""

from pathlib import Path

from methods import COLOURS, NAMES
from tables import Data, where

from .style import plt, save


def draw(data: Data, folder: Path) -> None:
    rows = data.read("fig1_points")
    samplers = list(dict.fromkeys(row["sampler"] for row in rows))
    figure, panels = plt.subplots(1, len(samplers), figsize=(10, 2.4))
    for axes, sampler in zip(panels, samplers, strict=True):
        _square(axes, NAMES[sampler], 4)
        _dots(axes, where(rows, sampler=sampler), COLOURS[sampler], 14)
    save(figure, folder, "fig1")

    rows = data.read("fig2_points")
    colours = {"even": "#2471a3", "odd": "#c0392b"}
    figure, panels = plt.subplots(1, 3, figsize=(7.5, 2.8))
    for axes, (title, parities) in zip(
        panels, {"(a) even-numbered": ["even"], "(b) odd-numbered": ["odd"], "(c) all": ["even", "odd"]}.items(),
        strict=True,
    ):  # fmt: skip
        _square(axes, title, 2)
        for parity in parities:
            _dots(axes, where(rows, parity=parity), colours[parity], 4)
    save(figure, folder, "fig2")


def _square(axes, title: str, cells: int) -> None:
    axes.set(title=title, xlim=(0, 1), ylim=(0, 1), aspect="equal")
    lines = [i / cells for i in range(cells + 1)]
    axes.set_xticks(lines, [""] * len(lines))
    axes.set_yticks(lines, [""] * len(lines))
    axes.tick_params(length=0)
    for side in ("top", "right"):
        axes.spines[side].set_visible(True)


def _dots(axes, rows, colour: str, size: float) -> None:
    axes.scatter([row["x"] for row in rows], [row["y"] for row in rows], s=size, color=colour, clip_on=False, zorder=3)
