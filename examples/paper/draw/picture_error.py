# SPDX-License-Identifier: GPL-3.0-or-later
"""Fig. 7: errors of the whole picture, and the slopes in the penumbra."""

from pathlib import Path

import numpy as np
from measure.picture_error import PAPER_COUNTS
from methods import ALL, HALTON, NAMES, OWEN_SOBOL, PRS, SOBOL, SPRS
from tables import Data, one, where

from .style import look, plt, save

SCENES = {"unoccluded": "nothing occludes", "occluded": "with the sphere"}


def draw(data: Data, folder: Path) -> None:
    rows = data.read("fig7_errors")
    _as_in_the_paper(rows, folder)
    _all_treatments(rows, folder)
    _penumbra(rows, folder)


def _curve(axes, rows, method, column: str, unit: float, counts=None) -> None:
    chosen = [row for row in where(rows, sampler=method.sampler, reuse=method.reuse)
              if counts is None or row["points"] in counts]  # fmt: skip
    axes.plot([row["points"] for row in chosen], [row[column] / unit for row in chosen], marker=".", **look(method))


def _as_in_the_paper(rows, folder: Path) -> None:
    figure, panels = plt.subplots(2, 2, figsize=(10, 7), sharex=True)
    for line, (column, name) in zip(panels, {"rmse": "RMS", "mean_absolute": "mean absolute"}.items(), strict=True):
        for axes, (scene, title) in zip(line, SCENES.items(), strict=True):
            here = where(rows, scene=scene)
            unit = one(here, sampler="PRS", points=4)[column]
            for method in (PRS, SPRS, SOBOL, HALTON, OWEN_SOBOL):
                _curve(axes, here, method, column, unit, PAPER_COUNTS)
            axes.set(yscale="log", xlabel="points on the luminaire", title=title)
            axes.set_ylabel(f"{name} error (PRS, 4 points = 1)")
            axes.set_xticks(PAPER_COUNTS)
    panels[0, 1].legend(loc="upper right")
    save(figure, folder, "fig7")


def _all_treatments(rows, folder: Path) -> None:
    figure, panels = plt.subplots(2, 3, figsize=(11, 6.6), sharex=True, sharey="row")
    for line, (scene, title) in zip(panels, SCENES.items(), strict=True):
        here = where(rows, scene=scene)
        unit = one(here, sampler="PRS", points=4)["rmse"]
        for axes, sampler in zip(line, ("SOBOL", "HALTON", "OWEN_SOBOL"), strict=True):
            _curve(axes, here, PRS, "rmse", unit)
            for method in ALL:
                if method.sampler == sampler:
                    _curve(axes, here, method, "rmse", unit)
            axes.set(xscale="log", yscale="log", title=f"{NAMES[sampler]}, {title}", xlabel="points on the luminaire")
            axes.legend(fontsize=7, loc="lower left")
        line[0].set_ylabel("RMS error (PRS, 4 points = 1)")
    save(figure, folder, "fig7_treatments")


def _penumbra(rows, folder: Path) -> None:
    figure, axes = plt.subplots(figsize=(6, 4.2))
    here = where(rows, scene="occluded")
    for method in (PRS, SPRS, SOBOL, HALTON, OWEN_SOBOL):
        _curve(axes, here, method, "penumbra_relative_rmse", 1.0)
    counts = np.array(sorted({row["points"] for row in here}))
    for exponent in (-0.5, -0.75):
        axes.plot(counts, 0.35 * (counts / 4) ** exponent, color="grey", linewidth=0.8, linestyle=(0, (6, 3)))
        axes.text(counts[-1], 0.35 * (counts[-1] / 4) ** exponent, f" $N^{{{exponent}}}$", color="grey", va="center")
    axes.set(xscale="log", yscale="log", xlabel="points on the luminaire", ylabel="RMS error / unshadowed radiance",
             title="the floor's penumbra")  # fmt: skip
    axes.legend(loc="lower left")
    save(figure, folder, "fig7_penumbra")
