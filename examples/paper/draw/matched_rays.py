# SPDX-License-Identifier: GPL-3.0-or-later
"""Fig. 8 and 9: four objects, crops with matched rays, where the points went, time against rays."""

from pathlib import Path

import numpy as np
from methods import COLOURS, NAMES
from tables import Data, one, where

from .style import error_scale, plt, save, show, show_error

WAYS = ("MC-FS", "MC-EBLS", "QMC-FS", "QMC-EBLS")
WORST = 0.1


def draw(data: Data, folder: Path) -> None:
    figure, axes = plt.subplots(figsize=(5.4, 4.1))
    show(axes, data.read_pictures("fig8")["whole"])
    save(figure, folder, "fig8", vector=False)
    _crops(data, folder)
    _counts(data, folder)
    _time(data, folder)


def _crops(data: Data, folder: Path) -> None:
    pictures = data.read_pictures("fig9")
    rows = where(data.read("fig9_errors"), qmc="Sobol', same")
    part = _penumbra_crop(pictures["floor"] > 0)
    figure, panels = plt.subplots(2, 5, figsize=(12, 4.1))
    for (top, bottom), letter, way in zip(panels.T, "abcd", WAYS, strict=False):
        row = one(rows, method=way)
        show(top, pictures[way][part], f"({letter}) {way}, {row['rays'] / 1e6:.2f} M rays")
        shown = show_error(bottom, pictures[way][part], pictures["reference"][part], WORST,
                           f"RMSE {row['rmse']:.4f}, penumbra {row['rmse_penumbra']:.4f}")  # fmt: skip
    show(panels[0, -1], pictures["reference"][part], "converged")
    error_scale(figure, panels[1, -1], shown)
    save(figure, folder, "fig9", vector=False)


def _penumbra_crop(mask: np.ndarray) -> tuple[slice, slice]:
    """The window of a quarter of the picture's width and height that has the most penumbra."""
    height, width = mask.shape
    h, w = height // 4, width // 4
    sums = np.pad(mask.cumsum(axis=0).cumsum(axis=1), ((1, 0), (1, 0)))
    count = sums[h:, w:] - sums[:-h, w:] - sums[h:, :-w] + sums[:-h, :-w]
    y, x = np.unravel_index(np.argmax(count), count.shape)
    return slice(y, y + h), slice(x, x + w)


def _counts(data: Data, folder: Path) -> None:
    pictures = data.read_pictures("fig9")
    figure, panels = plt.subplots(1, 2, figsize=(10, 3.6))
    for axes, way in zip(panels, ("MC-EBLS", "QMC-EBLS"), strict=True):
        shown = axes.imshow(pictures[f"{way} points"], origin="lower", cmap="viridis", vmin=10, vmax=60,
                            interpolation="nearest")  # fmt: skip
        axes.set(title=f"points used by {way}", xticks=[], yticks=[])
        axes.grid(False)
    figure.colorbar(shown, ax=panels, extend="max", shrink=0.9)
    save(figure, folder, "fig9_points", vector=False)


def _time(data: Data, folder: Path) -> None:
    rows = data.read("time_and_rays")
    figure, axes = plt.subplots(figsize=(5.6, 3.8))
    for rule, marker in (("FS", "o"), ("EBLS", "^")):
        for sampler in ("PRS", "SOBOL"):
            some = where(rows, rule=rule, sampler=sampler)
            axes.plot([r["rays"] / 1e6 for r in some], [r["seconds"] for r in some], marker, color=COLOURS[sampler],
                      markersize=5, label=f"{rule}, {NAMES[sampler]}")  # fmt: skip
    axes.set(xlabel="rays (millions)", ylabel="CPU seconds", xlim=(0, None), ylim=(0, None))
    axes.legend()
    save(figure, folder, "time_and_rays")
