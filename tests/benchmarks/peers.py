# SPDX-License-Identifier: GPL-3.0-or-later
"""Equal error against peers: Penumbra, Cycles (fixed and adaptive) and Mitsuba 3 on five kinds of scenes.

    blender -b --factory-startup -P tests/benchmarks/peers.py -- OUTPUT_FOLDER [PERCENTAGE [MITSUBA_PYTHON [SCENE ...]]]

320 x 240 pixels times the percentage, one ray through each pixel's centre, one thread, runs interleaved in one go.
MITSUBA_PYTHON: a Python that has Mitsuba (mitsuba_server.py), "-" for none. Error: against FIXED of another seed, in
r, g, b, away from the edges of objects and from what shows a lamp; how far Mitsuba's mean over its best run is from
that reference's is printed, so that all mean the same scene. Time: CPU seconds of the render call (Blender: export,
BVH and saving included; Mitsuba: after compiling its kernels once, BVH left out). Times at an error are interpolated
between the runs around it, log-log; ~: extrapolated beyond them. Writes peers.csv, peers.md and peers.png.
"""

import csv
import subprocess
import sys
from pathlib import Path

import bpy
import numpy as np

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parents[1] / "examples"), str(HERE.parents[1] / "tests/blender")]

import penumbra_addon  # noqa: E402

penumbra_addon.load()

import benchmark_scenes  # noqa: E402
from against_cycles import away_from_edges, plot  # noqa: E402
from against_cycles import picture as render  # noqa: E402

SCENES = ("open floor", "sphere", "four objects", "plants", "64 lights")
TARGETS = (0.01, 0.005, 0.002)
TOLERANCES = (0.06, 0.02, 0.008, 0.004)
SAMPLES = (8, 32, 128)
THRESHOLDS = (0.1, 0.03)
REFERENCE_POINTS = {"plants": 2048, "64 lights": 256}


def export(scene, path):
    """Triangles in world space with their albedo, square lamps as (world matrix, size, radiance), camera rays."""
    depsgraph = bpy.context.evaluated_depsgraph_get()
    arrays, lamps, meshes = {}, [], 0
    for instance in depsgraph.object_instances:
        thing = instance.object
        matrix = np.array(instance.matrix_world)
        if thing.type == "LIGHT":
            light = thing.data
            lamps.append(np.concatenate([matrix.ravel(), [light.size, light.energy / (4 * light.size**2)]]))
        if thing.type != "MESH":
            continue
        mesh = thing.to_mesh()
        mesh.calc_loop_triangles()
        positions = np.empty(3 * len(mesh.vertices), np.float32)
        mesh.vertices.foreach_get("co", positions)
        triangles = np.empty(3 * len(mesh.loop_triangles), np.int32)
        mesh.loop_triangles.foreach_get("vertices", triangles)
        positions = positions.reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3]
        if mesh.polygons[0].use_smooth:
            normals = np.empty(3 * len(mesh.vertices), np.float32)
            mesh.vertices.foreach_get("normal", normals)
            arrays[f"normals {meshes}"] = normals.reshape(-1, 3) @ np.linalg.inv(matrix[:3, :3])
        arrays[f"positions {meshes}"], arrays[f"triangles {meshes}"] = positions, triangles.reshape(-1, 3)
        meshes += 1
        thing.to_mesh_clear()
    width, height = (v * scene.render.resolution_percentage // 100 for v in (320, 240))
    camera = scene.camera
    frame = np.array(camera.data.view_frame(scene=scene))  # corners at some depth before the camera
    low, high = frame.min(0), frame.max(0)
    x = low[0] + (np.arange(width) + 0.5) / width * (high[0] - low[0])
    y = low[1] + (np.arange(height) + 0.5) / height * (high[1] - low[1])
    local = np.stack([*np.meshgrid(x, y), np.full((height, width), low[2])], axis=-1)
    matrix = np.array(camera.matrix_world)
    directions = local @ matrix[:3, :3].T
    directions /= np.linalg.norm(directions, axis=-1, keepdims=True)
    np.savez(path, lamps=np.array(lamps), directions=directions, eye=matrix[:3, 3], meshes=meshes,
             albedo=benchmark_scenes.ALBEDO, **arrays)  # fmt: skip


class Mitsuba:
    """A process of its own, asked by lines."""

    def __init__(self, python, scene_file):
        command = [python, str(HERE / "mitsuba_server.py"), str(scene_file)]
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.result = scene_file.with_suffix(".npy")

    def ask(self, text):
        self.process.stdin.write(f"{text}\n")
        self.process.stdin.flush()
        return float(self.process.stdout.readline()), np.load(self.result).astype(float)

    def close(self):
        self.process.stdin.close()
        self.process.wait()


def cycles(scene, samples, threshold):
    if threshold is None:
        return render(scene, None, samples)
    from helpers import use_cycles_as_reference

    use_cycles_as_reference(scene, samples)
    scene.cycles.use_adaptive_sampling, scene.cycles.adaptive_threshold = True, threshold
    from against_cycles import timed_render

    return timed_render(scene, "CYCLES")


def seconds_at(error, runs, key):
    """CPU seconds to an error, and whether they are extrapolated; those of the cheapest run if it is better yet."""
    cheapest = min(runs, key=lambda run: run["cpu_seconds"])
    if max(run[key] for run in runs) <= error:
        return cheapest["cpu_seconds"], False
    logs = np.log(sorted((run[key], run["cpu_seconds"]) for run in runs))
    i = int(np.clip(np.searchsorted(logs[:, 0], np.log(error)), 1, len(logs) - 1))
    (x0, y0), (x1, y1) = logs[i - 1], logs[i]
    beyond = not logs[0, 0] <= np.log(error) <= logs[-1, 0]
    return float(np.exp(y0 + (np.log(error) - x0) * (y1 - y0) / (x1 - x0))), beyond


def measure(name, percentage, python, folder):
    scene = benchmark_scenes.make(name)
    scene.render.resolution_x, scene.render.resolution_y = 320, 240
    scene.render.resolution_percentage = percentage
    scene.render.threads_mode, scene.render.threads = "FIXED", 1
    layer = scene.view_layers[0]
    layer.use_pass_z = layer.use_pass_normal = True
    fixed = {"stop_rule": "FIXED", "light_samples": REFERENCE_POINTS.get(name, 8192), "seed": 4711}
    passes, _ = render(scene, fixed, 0)
    true, inside = passes["Combined"][..., :3].astype(float), away_from_edges(passes)
    mitsuba = None
    if python != "-":
        export(scene, folder / "peers_scene.npz")
        mitsuba = Mitsuba(python, folder / "peers_scene.npz")
        _, lamp = mitsuba.ask("lamps")
        inside &= lamp[..., 0] == 0
    rows = []

    def add(renderer, setting, pixels, seconds):
        error = (pixels[..., :3].astype(float) - true)[inside]
        row = {"scene": name, "renderer": renderer, "setting": setting, "cpu_seconds": seconds}
        row["relative_rmse"] = np.sqrt((error**2).mean()) / true[inside].mean()
        row["p99"] = np.quantile(np.abs(error).max(-1), 0.99)
        row["mean"] = pixels[..., :3][inside].mean() / true[inside].mean() - 1
        rows.append(row)
        print(" ".join(f"{v:.4g}" if isinstance(v, float) else str(v) for v in row.values()), flush=True)

    for i in range(max(len(TOLERANCES), len(SAMPLES))):
        if i < len(TOLERANCES):
            passes, seconds = render(scene, {"error_tolerance": TOLERANCES[i]}, 0)
            add("Penumbra", TOLERANCES[i], passes["Combined"], seconds)
        if i < len(SAMPLES):
            passes, seconds = cycles(scene, SAMPLES[i], None)
            add("Cycles", SAMPLES[i], passes["Combined"], seconds)
        if i < len(SAMPLES) and mitsuba:
            seconds, pixels = mitsuba.ask(SAMPLES[i])
            add("Mitsuba", SAMPLES[i], pixels, seconds)
        if i < len(THRESHOLDS):
            passes, seconds = cycles(scene, 1024, THRESHOLDS[i])
            add("Cycles, adaptive", THRESHOLDS[i], passes["Combined"], seconds)
    if mitsuba:
        mitsuba.close()
    return rows


def table(rows):
    """Markdown: seconds and factors at each target."""
    lines = ["| scene | error | Penumbra | Cycles | factor | Mitsuba | factor |", "|---|---|---|---|---|---|---|"]
    for name in dict.fromkeys(row["scene"] for row in rows):
        for key, label in (("relative_rmse", "RMSE"), ("p99", "P99")):
            for target in TARGETS:
                cells = []
                ours, beyond = 0.0, False
                for renderer in ("Penumbra", "Cycles", "Mitsuba"):
                    runs = [r for r in rows if r["scene"] == name and r["renderer"] == renderer]
                    if not runs:
                        cells += ["", ""]
                        continue
                    seconds, guessed = seconds_at(target, runs, key)
                    cells.append(f"{'~' if guessed else ''}{seconds:.2g} s")
                    if renderer == "Penumbra":
                        ours, beyond = seconds, guessed
                    else:
                        cells.append(f"{'~' if guessed or beyond else ''}{seconds / ours:.0f}x")
                lines.append(f"| {name} | {label} {target:.1%} | " + " | ".join(cells) + " |")
    return lines


def main(folder, percentage=100, python="-", names=SCENES):
    folder.mkdir(parents=True, exist_ok=True)
    rows = []
    for name in names:
        rows += measure(name, int(percentage), python, folder)
        with open(folder / "peers.csv", "w", newline="") as file:
            writer = csv.DictWriter(file, rows[0].keys())
            writer.writeheader()
            writer.writerows(rows)
        (folder / "peers.md").write_text("\n".join(table(rows)) + "\n")
    print("\n".join(table(rows)))
    plot([{**row, "renderer": f"{row['scene']}: {row['renderer']}"} for row in rows], folder / "peers.png")


if __name__ == "__main__":
    arguments = sys.argv[sys.argv.index("--") + 1 :]
    main(Path(arguments[0]), *arguments[1:3], *([arguments[3:]] if arguments[3:] else []))
