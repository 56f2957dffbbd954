# SPDX-License-Identifier: GPL-3.0-or-later
"""Antialiased pictures at equal error: CPU time of Penumbra's tolerances against Cycles' samples, scene by scene.

    blender -b --factory-startup -P tests/benchmarks/antialiased.py -- OUTPUT_FOLDER [SCENE ...]

320 x 240 pixels, the same Blackman-Harris filter in both, one thread, everything in one run; the scenes are those of
benchmark_scenes.py. Error: the largest difference of r, g, b in each pixel from Penumbra's own FIXED pictures of two
seeds with 1024 x 8 points a pixel (256 x 8 on the plants), which know nothing of BOUNDED; half their own difference is
printed as the reference's error. Time: CPU seconds of bpy.ops.render.render, export included, saving not. For the 99th
percentiles in TARGETS the times are interpolated (log-log) between the runs around them; the factor is Cycles' over
Penumbra's. Also: what the tolerance of that value itself took. Writes antialiased.csv.
"""

import csv
import sys
from pathlib import Path

import numpy as np

REPOSITORY = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(Path(__file__).resolve().parent), str(REPOSITORY / "examples"), str(REPOSITORY / "tests/blender")]

import penumbra_addon  # noqa: E402

penumbra_addon.load()

import benchmark_scenes  # noqa: E402
from against_cycles import timed_render  # noqa: E402
from helpers import use_cycles_as_reference  # noqa: E402

TARGETS = (0.01, 0.004)
TOLERANCES = (0.04, 0.02, 0.014, 0.01, 0.007, 0.004)
SAMPLES = (16, 64, 256, 1024)


def colours(scene, engine):
    """r, g, b of a render, and its CPU seconds."""
    passes, seconds = timed_render(scene, engine)
    return passes["Combined"][..., :3].astype(float), seconds


def reference(scene, rays):
    """The mean of two pictures, and half their difference's 99th percentile."""
    scene.penumbra.stop_rule, scene.penumbra.pixel_samples, scene.penumbra.light_samples = "FIXED", rays, 8
    scene.render.threads_mode = "AUTO"
    pictures = []
    for scene.penumbra.seed in (4711, 4712):
        pictures.append(colours(scene, "PENUMBRA")[0])
    scene.penumbra.seed, scene.penumbra.stop_rule = 0, "BOUNDED"
    scene.render.threads_mode, scene.render.threads = "FIXED", 1
    return (pictures[0] + pictures[1]) / 2, p99(pictures[0], pictures[1]) / 2


def p99(picture, true):
    return np.quantile(np.abs(picture - true).max(axis=-1), 0.99)


def seconds_at(error, runs):
    """CPU seconds to a 99th percentile, interpolated; extrapolated with the slope of the last two runs if need be."""
    logs = np.log(sorted((run["p99"], run["seconds"]) for run in runs))
    i = int(np.clip(np.searchsorted(logs[:, 0], np.log(error)), 1, len(logs) - 1))
    (x0, y0), (x1, y1) = logs[i - 1], logs[i]
    return float(np.exp(y0 + (np.log(error) - x0) * (y1 - y0) / (x1 - x0)))


def measure(name):
    """All runs on one scene, as rows."""
    scene = benchmark_scenes.make(name)
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 320, 240, 100
    true, own_error = reference(scene, 256 if name == "plants" else 1024)
    print(f"{name}: 99th percentile of the reference's own error {own_error:.5f}", flush=True)
    rows = []

    def add(renderer, setting, picture, seconds):
        error = np.abs(picture - true).max(axis=-1)
        within = (error <= setting).mean() if renderer == "Penumbra" else float("nan")
        rmse = np.sqrt(((picture - true) ** 2).mean()) / true.mean()
        rows.append(
            {
                "scene": name,
                "renderer": renderer,
                "setting": setting,
                "seconds": round(seconds, 3),
                "p99": p99(picture, true),
                "relative_rmse": rmse,
                "max": error.max(),
                "within": within,
            }
        )
        print("  " + " ".join(f"{v:.5g}" if isinstance(v, float) else f"{v}" for v in rows[-1].values()), flush=True)

    for tolerance in TOLERANCES[:4] if name == "plants" else TOLERANCES:
        scene.penumbra.error_tolerance = tolerance
        add("Penumbra", tolerance, *colours(scene, "PENUMBRA"))
    for samples in SAMPLES:
        use_cycles_as_reference(scene, samples)
        scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BLACKMAN_HARRIS", scene.penumbra.filter_width
        add("Cycles", samples, *colours(scene, "CYCLES"))
    return rows


def summary(rows):
    """Lines with the factor at each target."""
    own = [row for row in rows if row["renderer"] == "Penumbra"]
    peer = [row for row in rows if row["renderer"] == "Cycles"]
    for target in TARGETS:
        ours, theirs = seconds_at(target, own), seconds_at(target, peer)
        line = f"{rows[0]['scene']}: P99 {target}: {ours:.2f} s, Cycles {theirs:.1f} s, factor {theirs / ours:.0f}"
        asked = [row["seconds"] for row in own if row["setting"] == target]
        yield line + (f", with the promise {theirs / asked[0]:.0f}" if asked else "")


def main(folder, names):
    rows, lines = [], []
    for name in names:
        found = measure(name)
        rows += found
        lines += summary(found)
    folder.mkdir(parents=True, exist_ok=True)
    with open(folder / "antialiased.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, rows[0].keys())
        writer.writeheader()
        writer.writerows(rows)
    print("\n".join(lines))


arguments = sys.argv[sys.argv.index("--") + 1 :]
main(Path(arguments[0]), arguments[1:] or list(benchmark_scenes.SCENES))
