# SPDX-License-Identifier: GPL-3.0-or-later
"""Compares the example scene's pictures of several Blenders: compare.py FOLDER, with NAME/picture.exr in it.

Writes FOLDER/side_by_side.png: each picture above its difference from the first. Exits with 1 where two differ by more
than the error tolerance that each of them keeps, or where there are fewer than two.
"""

import json
import sys
from pathlib import Path

import matplotlib
import numpy as np
import OpenImageIO as oiio

matplotlib.use("Agg")
from matplotlib import pyplot as plt  # noqa: E402  (after the choice of the backend)

TOLERANCE = 0.004
"""The scene's own error_tolerance, in display units: 99 % of the pixels keep it against the truth. So two pictures may
differ by twice that; they are made by the same arithmetic and are asked for once."""


def read(path: Path) -> np.ndarray:
    """(height, width, 3) float32, row 0 = top."""
    return np.asarray(oiio.ImageBuf(str(path)).get_pixels(oiio.FLOAT))[..., :3]


def main(folder: Path) -> int:
    names = sorted(path.parent.name for path in folder.glob("*/picture.exr"))
    if len(names) < 2:
        print(f"compare.py: {len(names)} pictures in {folder}, expected two or more")
        return 1
    first = read(folder / names[0] / "picture.exr")
    figure, axes = plt.subplots(2, len(names), figsize=(4 * len(names), 6.4), squeeze=False, layout="constrained")
    worst = 0.0
    for column, name in zip(axes.T, names, strict=True):
        difference = np.abs(read(folder / name / "picture.exr") - first).max(-1)
        bound = float(np.quantile(difference, 0.99))
        worst = max(worst, bound)
        about = json.loads((folder / name / "about.json").read_text(encoding="utf-8"))
        column[0].imshow(plt.imread(folder / name / "picture.png"))
        column[0].set_title(f"{name}: " + ", ".join(" ".join(item) for item in about.items()), fontsize=8)
        column[1].imshow(difference, cmap="inferno", vmin=0, vmax=TOLERANCE)
        text = f"99th percentile {bound:.2g}, largest {difference.max():.2g}"
        column[1].set_title(f"difference from {names[0]}, white: {TOLERANCE}\n{text}", fontsize=8)
        print(f"{name}: {about}, {text}")
    for axis in axes.flat:
        axis.axis("off")
    figure.savefig(folder / "side_by_side.png", dpi=110)
    return int(worst > TOLERANCE)


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
