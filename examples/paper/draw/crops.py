# SPDX-License-Identifier: GPL-3.0-or-later
"""Fig. 4 and 5: the sphere's picture and its penumbra, sampler by sampler."""

from pathlib import Path

from matplotlib.patches import Rectangle
from measure.crops import SHOWN
from tables import Data, one

from .style import error_scale, plt, save, show, show_error

WORST = 0.1


def draw(data: Data, folder: Path) -> None:
    whole = data.read_pictures("fig4")
    figure, axes = plt.subplots(figsize=(5.4, 4.1))
    show(axes, whole["whole"])
    x, y, width, height = (int(n) for n in whole["crop"])
    axes.add_patch(Rectangle((x, y), width, height, fill=False, edgecolor="#c0392b"))
    save(figure, folder, "fig4", vector=False)

    pictures, rows = data.read_pictures("fig5"), data.read("fig5_errors")
    figure, panels = plt.subplots(2, len(SHOWN) + 1, figsize=(13, 3.4))
    for (top, bottom), method in zip(panels.T, SHOWN, strict=False):
        picture = pictures[method.label]
        show(top, picture, method.label)
        error = one(rows, sampler=method.sampler, reuse=method.reuse)["rmse"]
        shown = show_error(bottom, picture, pictures["reference"], WORST, f"RMSE {error:.4f}")
    show(panels[0, -1], pictures["reference"], "converged")
    error_scale(figure, panels[1, -1], shown)
    save(figure, folder, "fig5", vector=False)
