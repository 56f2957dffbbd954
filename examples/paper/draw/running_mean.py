# SPDX-License-Identifier: GPL-3.0-or-later
"""Fig. 6: running means at a floor point in the light and one in the penumbra."""

from pathlib import Path

from measure.running_mean import SHOWN
from tables import Data, where

from .style import look, plt, save

RANGE = {"lit": 0.06, "penumbra": 0.4}


def draw(data: Data, folder: Path) -> None:
    rows = data.read("fig6_curves")
    figure, panels = plt.subplots(1, 2, figsize=(10, 3.6))
    for axes, part in zip(panels, RANGE, strict=True):
        for method in SHOWN:
            curve = where(rows, part=part, sampler=method.sampler)
            axes.plot([row["points"] for row in curve], [row["value"] / row["exact"] for row in curve], **look(method))
        axes.axhline(1, color="black", linewidth=0.7)
        axes.set(xscale="log", xlabel="points on the luminaire", ylabel="radiance / exact",
                 title=f"a floor point in the {'light' if part == 'lit' else part}",
                 ylim=(1 - RANGE[part], 1 + RANGE[part]))  # fmt: skip
    panels[1].legend(loc="upper right")
    save(figure, folder, "fig6")
