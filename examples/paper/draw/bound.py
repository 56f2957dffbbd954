# SPDX-License-Identifier: GPL-3.0-or-later
"""Does the bound hold? Shares of pixels beyond eps, and where they are."""

from pathlib import Path

import numpy as np
from matplotlib.colors import ListedColormap
from measure.bound import METHODS, PAPER_EPS, RULES
from methods import OWEN_SOBOL
from tables import Data, where

from .style import bare, look, plt, save, show

LEAST_PERCENT = 0.01
"""Shown for anything less."""


def draw(data: Data, folder: Path) -> None:
    rows = data.read("bound")
    figure, panels = plt.subplots(1, len(RULES), figsize=(12, 3.3), sharey=True)
    for axes, rule in zip(panels, RULES, strict=True):
        for method in [OWEN_SOBOL] if rule == "BOUNDED" else METHODS:
            some = where(rows, rule=rule, sampler=method.sampler, reuse=method.reuse)
            percents = [max(100 * r["beyond"], LEAST_PERCENT) for r in some]
            axes.plot([r["eps"] for r in some], percents, marker=".", **look(method))
        axes.axhline(1, color="black", linewidth=0.7)
        title = "BOUNDED (this engine's own)" if rule == "BOUNDED" else rule
        axes.set(xscale="log", yscale="log", title=title, ylim=(LEAST_PERCENT / 2, 100), xlabel="eps")
        axes.set_xticks([0.02, 0.01, 0.004, 0.002, 0.001], [".02", ".01", ".004", ".002", ".001"], minor=False)
        axes.minorticks_off()
    panels[0].set_ylabel("pixels beyond eps (%)")
    panels[0].legend(loc="lower left", fontsize=7)
    save(figure, folder, "bound")

    pictures = data.read_pictures("bound")
    error = np.max(np.abs(pictures["picture"] - pictures["reference"]), axis=-1)
    levels = np.digitize(error, [PAPER_EPS, 2 * PAPER_EPS, 5 * PAPER_EPS])
    figure, panels = plt.subplots(1, 2, figsize=(10, 3.8))
    show(panels[0], pictures["picture"], "PAPER, Sobol' same, eps = 0.004")
    colours = ListedColormap(["#f2f2f2", "#f6c667", "#e2711d", "#9d0208"])
    shown = panels[1].imshow(levels, origin="lower", interpolation="nearest", cmap=colours, vmin=-0.5, vmax=3.5)
    bare(panels[1], "its true error")
    bar = figure.colorbar(shown, ax=panels[1], ticks=range(4), shrink=0.8)
    bar.ax.set_yticklabels(["within eps", "1 to 2 eps", "2 to 5 eps", "above 5 eps"])
    save(figure, folder, "bound_map", vector=False)
