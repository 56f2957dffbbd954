# SPDX-License-Identifier: GPL-3.0-or-later
"""Compares pictures of the example scene by several Blenders, FOLDER/NAME/picture.exr: compare.py FOLDER NAME NAME...

Writes FOLDER/side_by_side.png: each picture above its difference from the first. Exits with 1 where one differs from
the first by more than the error tolerance that each of them keeps, or is missing.
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


def main(folder: Path, names: list[str]) -> int:
    missing = [name for name in names if not (folder / name / "picture.exr").exists()]
    if missing or len(names) < 2:
        print(f"compare.py: two or more pictures are wanted; missing in {folder}: {', '.join(missing) or 'none'}")
        return 1
    first = read(folder / names[0] / "picture.exr")
    agree = 0.1 < first.max() < np.inf  # not black
    figure, axes = plt.subplots(2, len(names), figsize=(4 * len(names), 6.4), squeeze=False, layout="constrained")
    for column, name in zip(axes.T, names, strict=True):
        difference = np.abs(read(folder / name / "picture.exr") - first).max(-1)
        bound = float(np.quantile(difference, 0.99))
        agree &= bound <= TOLERANCE
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
    print("The pictures agree." if agree else "The pictures differ.")
    return int(not agree)


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]), sys.argv[2:]))
