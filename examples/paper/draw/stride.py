# SPDX-License-Identifier: GPL-3.0-or-later
"""The artifact of taking every other Sobol' point."""

from pathlib import Path

import numpy as np
from tables import Data

from .style import plt, save, show

TITLES = {
    "careful": "all pixels use the same 16 points", "striding": "even and odd points by columns",
    "halved": "every pixel the even points", "reference": "converged",
}  # fmt: skip


def draw(data: Data, folder: Path) -> None:
    pictures = data.read_pictures("stride")
    height, width = pictures["reference"].shape[:2]
    part = np.s_[int(0.08 * height) : int(0.62 * height), int(0.16 * width) : int(0.62 * width)]
    figure, panels = plt.subplots(1, 4, figsize=(10, 2.4))
    for axes, (name, title) in zip(panels, TITLES.items(), strict=True):
        show(axes, pictures[name][part], title)
    save(figure, folder, "stride", vector=False)
