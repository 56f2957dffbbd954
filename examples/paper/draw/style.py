# SPDX-License-Identifier: GPL-3.0-or-later
"""How all figures look, and how pictures are shown."""

from pathlib import Path

import matplotlib

matplotlib.use("Agg")

import numpy as np  # noqa: E402
from matplotlib import pyplot as plt  # noqa: E402  (after the choice of a backend without a window)
from methods import COLOURS, NAMES, Method  # noqa: E402

plt.rcParams.update({
    "font.size": 9, "axes.titlesize": 9, "axes.spines.top": False, "axes.spines.right": False, "axes.grid": True,
    "grid.color": "#e4e4e4", "grid.linewidth": 0.6, "legend.frameon": False, "lines.linewidth": 1.4,
    "figure.constrained_layout.use": True, "svg.fonttype": "none", "savefig.dpi": 150,
})  # fmt: skip
DASHES = {"SAME": "-", "CONTINUED": "--", "ROTATED": ":", "SCRAMBLED": "-."}
ERROR_COLOURS = "inferno"


def save(figure, folder: Path, name: str, vector: bool = True) -> None:
    """As PNG, and as SVG if it is a plot."""
    figure.savefig(folder / f"{name}.png")
    if vector:
        figure.savefig(folder / f"{name}.svg")
    plt.close(figure)


def look(method: Method) -> dict:
    """Colour, dashes and name of a method's line."""
    return {"color": COLOURS[method.sampler], "linestyle": DASHES[method.reuse], "label": method.label}


def name_of(sampler: str) -> str:
    return NAMES[sampler]


def srgb(display: np.ndarray) -> np.ndarray:
    """Display units as the screen shows them: sRGB's curve."""
    x = np.clip(display, 0, 1)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)


def show(axes, display: np.ndarray, title: str = "") -> None:
    """A picture, its rows bottom first, every pixel a sharp square."""
    axes.imshow(srgb(display), origin="lower", interpolation="nearest")
    bare(axes, title)


def show_error(axes, picture: np.ndarray, reference: np.ndarray, largest: float, title: str = ""):
    """Largest of |r|, |g|, |b|, from black (0) to pale yellow (`largest`)."""
    error = np.max(np.abs(picture - reference), axis=-1)
    shown = axes.imshow(error, origin="lower", interpolation="nearest", cmap=ERROR_COLOURS, vmin=0, vmax=largest)
    bare(axes, title)
    return shown


def error_scale(figure, axes, shown) -> None:
    """The scale of error pictures in a panel of its own."""
    axes.axis("off")
    bar = axes.inset_axes([0.1, 0.05, 0.07, 0.9])
    bar.grid(False)
    figure.colorbar(shown, cax=bar, label="error (white = 1)")


def bare(axes, title: str) -> None:
    axes.set_title(title)
    axes.set_xticks([])
    axes.set_yticks([])
    axes.grid(False)
    for spine in axes.spines.values():
        spine.set_visible(False)
