# SPDX-License-Identifier: GPL-3.0-or-later
"""The three terms of the BRDF: a picture, and lobes beside those of Cycles."""

from pathlib import Path

from measure.brdf import ROUGHNESSES
from tables import Data, where

from .style import plt, save, show


def draw(data: Data, folder: Path) -> None:
    figure, axes = plt.subplots(figsize=(6.4, 4.9))
    show(axes, data.read_pictures("brdf")["picture"])
    save(figure, folder, "brdf", vector=False)

    rows = data.read("brdf_lobes")
    figure, axes = plt.subplots(figsize=(6.4, 3.8))
    for roughness, colour in zip(ROUGHNESSES, ("#2471a3", "#1e8449", "#c0392b"), strict=True):
        for engine, line, name in (("PENUMBRA", "-", "Phong"), ("CYCLES", ":", "Cycles' GGX")):
            some = where(rows, roughness=roughness, engine=engine)
            axes.plot([r["degrees"] for r in some], [r["radiance"] for r in some], line, color=colour,
                      label=f"{name}, roughness {roughness:g}")  # fmt: skip
    axes.set(xlabel="degrees on the floor from below the luminaire", ylabel="radiance (peak = 1)")
    axes.legend(fontsize=7)
    save(figure, folder, "brdf_lobes")
