# SPDX-License-Identifier: GPL-3.0-or-later
"""Speed against error on the example scene: Penumbra's tolerances and fixed points against Cycles' samples.

    blender -b examples/four_objects.blend -P tests/benchmarks/against_cycles.py -- OUTPUT_FOLDER [PERCENTAGE]

One centre ray a pixel, one thread, everything in one run. Error: against 16384 fixed Owen-Sobol' points of another
seed, away from the edges of objects (a pixel's centre there may hit another object in each renderer). Time: CPU
seconds of bpy.ops.render.render, synchronisation included, saving the picture not. Writes speed_against_error.csv and
.png and prints a table.
"""

import csv
import resource
import sys
import tempfile
from pathlib import Path

import bpy
import numpy as np

REPOSITORY = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(REPOSITORY / "examples"), str(REPOSITORY / "tests" / "blender")]

import penumbra_addon  # noqa: E402

penumbra_addon.load()

from helpers import prepare_render, read_exr, use_cycles_as_reference  # noqa: E402

REFERENCE = {"stop_rule": "FIXED", "light_samples": 16384, "seed": 4711}
RUNS = (
    [("Penumbra, BOUNDED", eps, {"error_tolerance": eps}) for eps in (0.02, 0.01, 0.004, 0.002, 0.001)]
    + [("Penumbra, FIXED", n, {"stop_rule": "FIXED", "light_samples": n}) for n in (16, 64, 256, 1024)]
    + [("Cycles", n, None) for n in (16, 64, 256, 1024)]
)


def cpu_seconds() -> float:
    used = resource.getrusage(resource.RUSAGE_SELF)
    return used.ru_utime + used.ru_stime


def timed_render(scene, engine: str) -> tuple[dict, float]:
    """All passes, and the CPU seconds of bpy.ops.render.render: export included, saving the picture not."""
    prepare_render(scene, engine)
    start = cpu_seconds()
    bpy.ops.render.render(scene=scene.name)
    seconds = cpu_seconds() - start
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "render.exr"
        bpy.data.images["Render Result"].save_render(str(path), scene=scene)
        return read_exr(path), seconds


def picture(scene, settings: dict | None, samples: int) -> tuple[dict, float]:
    """All passes of one render, and its CPU seconds. `settings` None: Cycles with so many samples."""
    if settings is None:
        use_cycles_as_reference(scene, samples)
    else:
        for setting in scene.penumbra.bl_rna.properties:
            if not setting.is_readonly:
                scene.penumbra.property_unset(setting.identifier)
        scene.penumbra.pixel_samples = 1
        for name, value in settings.items():
            setattr(scene.penumbra, name, value)
    return timed_render(scene, "CYCLES" if settings is None else "PENUMBRA")


def away_from_edges(passes: dict) -> np.ndarray:
    """Pixels none of whose 5 x 5 neighbours lies on another surface or faces elsewhere."""
    normal, depth = passes["Normal"], passes["Depth"][..., 0]
    inside = np.ones(depth.shape, bool)
    for dy in range(-2, 3):
        for dx in range(-2, 3):
            shifted = np.roll(normal, (dy, dx), (0, 1))
            inside &= (normal * shifted).sum(-1) > 0.9
            inside &= np.abs(np.roll(depth, (dy, dx), (0, 1)) / depth - 1) < 0.05
    inside[:2] = inside[-2:] = inside[:, :2] = inside[:, -2:] = False
    return inside


def plot(rows: list[dict], path: Path) -> None:
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=(7, 4.5))
    for name in dict.fromkeys(row["renderer"] for row in rows):
        own = [row for row in rows if row["renderer"] == name]
        axes.loglog([r["cpu_seconds"] for r in own], [r["relative_rmse"] for r in own], "o-", label=name)
    axes.set_xlabel("CPU seconds, one thread")
    axes.set_ylabel("relative RMSE")
    axes.grid(True, which="both", alpha=0.3)
    axes.legend()
    figure.tight_layout()
    figure.savefig(path, dpi=120)


def main(folder: Path, percentage: int) -> None:
    scene = bpy.context.scene
    scene.render.resolution_percentage = percentage
    scene.render.threads_mode, scene.render.threads = "FIXED", 1
    layer = scene.view_layers[0]
    layer.use_pass_z = layer.use_pass_normal = True
    passes, _ = picture(scene, REFERENCE, 0)
    true, inside = passes["Combined"][..., :3].astype(float), away_from_edges(passes)
    rows = []
    for renderer, value, settings in RUNS:
        passes, seconds = picture(scene, settings, value)
        error = (passes["Combined"][..., :3].astype(float) - true)[inside]
        rows.append(
            {
                "renderer": renderer,
                "setting": value,
                "cpu_seconds": round(seconds, 3),
                "relative_rmse": np.sqrt((error**2).mean()) / true[inside].mean(),
                "p99": np.quantile(np.abs(error).max(-1), 0.99),
                "max": np.abs(error).max(),
            }
        )
        print(" ".join(f"{v:>18.5g}" if isinstance(v, float) else f"{v:>18}" for v in rows[-1].values()), flush=True)
    folder.mkdir(parents=True, exist_ok=True)
    with open(folder / "speed_against_error.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, rows[0].keys())
        writer.writeheader()
        writer.writerows(rows)
    plot(rows, folder / "speed_against_error.png")


if __name__ == "__main__":
    arguments = sys.argv[sys.argv.index("--") + 1 :]
    main(Path(arguments[0]), int(arguments[1]) if len(arguments) > 1 else 100)
