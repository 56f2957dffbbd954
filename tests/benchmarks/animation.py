# SPDX-License-Identifier: GPL-3.0-or-later
"""Frames of an animation: what each takes, and whether anything grows. A table and animation.csv.

    blender -b --factory-startup --python-exit-code 1 -P tests/benchmarks/animation.py -- OUTPUT_FOLDER [FRAMES]

A camera that goes round one of the scenes of benchmark_scenes.py, 320 x 240, BOUNDED with the default tolerance, one
centre ray a pixel, one thread, with and without Blender's Persistent Data. By frame: CPU seconds of
bpy.ops.render.render and, of these, of the thread that Blender calls in, which does all but the native render
(Blender's synchronisation, export, BVH, pixels back); the process' memory after it.
"""

import csv
import math
import sys
import time
from pathlib import Path

import bpy

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parents[1] / "examples"), str(HERE.parents[1] / "tests/blender")]

import penumbra_addon  # noqa: E402

penumbra_addon.load()

import benchmark_scenes  # noqa: E402
from against_cycles import cpu_seconds  # noqa: E402
from helpers import prepare_render  # noqa: E402

SCENES = ("four objects", "plants")


def resident_mib() -> float:
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith("VmRSS:"):
            return int(line.split()[1]) / 1024
    raise RuntimeError("no VmRSS in /proc/self/status")


def turn(scene, frame: int, frames: int) -> None:
    """The camera goes an eighth of the way round the origin."""
    scene.frame_set(frame)
    scene.camera.parent.rotation_euler.z = math.pi / 4 * frame / frames


def measure(name: str, persistent: bool, frames: int) -> list[dict]:
    scene = benchmark_scenes.make(name)
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 320, 240, 100
    scene.render.threads_mode, scene.render.threads = "FIXED", 1
    scene.render.use_persistent_data = persistent
    scene.penumbra.pixel_samples = 1
    pivot = bpy.data.objects.new("Pivot", None)
    scene.collection.objects.link(pivot)
    scene.camera.parent = pivot
    prepare_render(scene, "PENUMBRA")
    rows = []
    for frame in range(frames):
        turn(scene, frame, frames)
        start, own_start = cpu_seconds(), time.thread_time()
        bpy.ops.render.render(scene=scene.name)
        seconds, own = cpu_seconds() - start, time.thread_time() - own_start
        rows.append({"scene": name, "persistent": persistent, "frame": frame, "cpu_seconds": seconds,
                     "beside_the_render": own, "resident_mib": resident_mib()})  # fmt: skip
    return rows


def main(folder: Path, frames: int) -> None:
    rows = []
    for name in SCENES:
        for persistent in (False, True):
            found = measure(name, persistent, frames)
            rows += found
            first, last = found[0], found[-1]
            later = sorted(row["cpu_seconds"] for row in found[1:])
            beside = sorted(row["beside_the_render"] for row in found[1:])
            print(f"animation: {name}, persistent data {'on' if persistent else 'off'}: first frame "
                  f"{first['cpu_seconds']:.3f} s, median of the others {later[len(later) // 2]:.3f} s, "
                  f"beside the render {beside[len(beside) // 2]:.3f} s; memory {first['resident_mib']:.0f} MiB after "
                  f"the first, {last['resident_mib']:.0f} after frame {frames}", flush=True)  # fmt: skip
    folder.mkdir(parents=True, exist_ok=True)
    with open(folder / "animation.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, rows[0].keys())
        writer.writeheader()
        writer.writerows(rows)


arguments = sys.argv[sys.argv.index("--") + 1 :]
main(Path(arguments[0]), int(arguments[1]) if len(arguments) > 1 else 10)
