# SPDX-License-Identifier: GPL-3.0-or-later
"""The figures, drawn with Matplotlib, which is imported only here and only when a figure is drawn."""

import sys
from pathlib import Path

import numpy as np

from .study import Picture, Study

DPI = 110
COLOURS = {"BOUNDED": "#d55e00", "FIXED": "#0072b2", "PAPER": "#009e73", "VARIANCE": "#b0589a", "Cycles": "#222222"}
MARKERS = {"OWEN_SOBOL": "o-", "SOBOL": "s--", "HALTON": "^-.", "SPRS": "D--", "PRS": "x:", "": "P-"}
"""Colour tells the stop rule, marker and dashes the sampler."""

TIMES_TOLERANCE = 16.0
"""The error images reach from the tolerance divided by this to the tolerance times this."""


def require() -> None:
    """RuntimeError with what to do, if Matplotlib is missing."""
    try:
        import matplotlib.figure  # noqa: F401
    except ImportError as error:
        version = f"{sys.version_info.major}.{sys.version_info.minor}"
        raise RuntimeError(
            f"report: the plots need Matplotlib, which Blender's Python {version} cannot import ({error}): install"
            f" python3-matplotlib (Debian), or run `{sys.executable} -m pip install matplotlib`"
        ) from error


def _figure(width: float, height: float):
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), dpi=DPI, layout="constrained")


def speed_against_error(study: Study, path: Path) -> None:
    """99th-percentile error and RMSE against seconds, both logarithmic, a curve for each family."""
    figure = _figure(11.0, 6.0)
    *axes, below = figure.subplot_mosaic(
        [["left", "right"], ["legend", "legend"]], gridspec_kw={"height_ratios": [5, 1]}
    ).values()
    columns = (("p99", "error that 99 % of the pixels keep"), ("rmse", "root mean square error"))
    for axis, (column, label) in zip(axes, columns, strict=True):
        for family, rows in study.families().items():
            _curve(axis, family, rows, column)
        own = [row for row in study.rows if row["own_settings"]]
        axis.plot([row["seconds"] for row in own], [row[column] for row in own], "*", color="gold", markersize=17,
                  markeredgecolor="black", zorder=5, label="your settings")  # fmt: skip
        axis.set(xscale="log", yscale="log", xlabel="seconds", ylabel=f"{label}, 1 = white")
        axis.grid(True, which="major", alpha=0.35)
        axis.grid(True, which="minor", alpha=0.12)
    axes[0].axhline(study.own["error_tolerance"], color="grey", linewidth=1, linestyle=(0, (6, 3)),
                    label="your tolerance", zorder=1)  # fmt: skip
    below.set_axis_off()
    below.legend(*axes[0].get_legend_handles_labels(), loc="center", ncols=4, frameon=False, fontsize=8.5)
    figure.savefig(path, bbox_inches="tight")


def _curve(axis, family: str, rows: list[dict], column: str) -> None:
    rule, _, sampler = family.partition(", ")
    important = rule in ("BOUNDED", "Cycles")
    axis.plot(
        [row["seconds"] for row in rows], [max(row[column], 1e-12) for row in rows],
        MARKERS.get(sampler.partition(" ")[0], "o-"), color=COLOURS[rule], label=family,
        linewidth=2.4 if important else 1.1, markersize=6 if important else 4.5, zorder=4 if important else 3,
    )  # fmt: skip


def _image_figure(shape: tuple[int, int]):
    """A figure for an image of that shape (height, width) with a colour bar beneath."""
    width = 6.0 if shape[1] >= shape[0] else 4.0
    figure = _figure(width, width * shape[0] / shape[1] + 0.9)
    axis = figure.subplots()
    axis.set_axis_off()
    return figure, axis


def _colour_bar(figure, axis, image, label: str, **more) -> None:
    bar = figure.colorbar(image, ax=axis, orientation="horizontal", aspect=45, pad=0.02, **more)
    bar.set_label(label, fontsize=8.5)
    bar.ax.tick_params(labelsize=8)


def error_image(picture: Picture, path: Path) -> None:
    """Blue where the tolerance is kept, white at the tolerance, red where it is broken."""
    from matplotlib.colors import LogNorm

    tolerance = picture.row["tolerance"]
    low, high = tolerance / TIMES_TOLERANCE, tolerance * TIMES_TOLERANCE
    figure, axis = _image_figure(picture.errors.shape)
    image = axis.imshow(np.clip(picture.errors, low, high), origin="lower", interpolation="nearest", cmap="RdBu_r",
                        norm=LogNorm(low, high))  # fmt: skip
    steps = [tolerance * 4.0**i for i in range(-2, 3)]
    _colour_bar(figure, axis, image, f"error; white: the tolerance {tolerance:g}", ticks=steps,
                format=lambda value, _: f"{value:.2g}", extend="both")  # fmt: skip
    image.colorbar.minorticks_off()
    figure.savefig(path, bbox_inches="tight")


def sample_image(picture: Picture, path: Path) -> None:
    """Light points of each pixel on a logarithmic scale; black where there are none."""
    from matplotlib import colormaps
    from matplotlib.colors import LogNorm

    figure, axis = _image_figure(picture.samples.shape)
    most = max(float(picture.samples.max()), 2.0)
    colours = colormaps["viridis"].with_extremes(bad="black")
    image = axis.imshow(np.ma.masked_less_equal(picture.samples, 0), origin="lower", interpolation="nearest",
                        cmap=colours, norm=LogNorm(1, most))  # fmt: skip
    _colour_bar(figure, axis, image, f"light points a pixel, at most {most:,.0f}, on average"
                f" {picture.samples.mean():,.1f}", format=lambda value, _: f"{value:g}")  # fmt: skip
    figure.savefig(path, bbox_inches="tight")


def reference_image(study: Study, path: Path) -> None:
    """The reference with its exposure, as an sRGB screen shows it; what is above white is cut off."""
    display = np.clip(study.reference.colour * study.display_scale, 0, 1)
    display = np.where(display <= 0.0031308, 12.92 * display, 1.055 * display ** (1 / 2.4) - 0.055)  # IEC 61966-2-1
    from matplotlib.image import imsave

    imsave(path, display, origin="lower")
