# SPDX-License-Identifier: GPL-3.0-or-later
"""Equal error against peers: Penumbra, Cycles (fixed and adaptive) and Mitsuba 3 on five kinds of scenes.

    bash tests/benchmarks/run.sh peers [peers_sid]
    blender -b --factory-startup -P tests/benchmarks/peers.py -- OUTPUT_FOLDER [PERCENTAGE [MITSUBA_PYTHON [SCENE ...]]]

640 x 480 pixels times the percentage, one ray through each pixel's centre, one thread, runs interleaved in one go.
MITSUBA_PYTHON: a Python that has Mitsuba (mitsuba_server.py), "-" for none. Error: against FIXED of another seed, in
r, g, b, away from the edges of objects and from what shows a lamp; how far each run's mean is from that reference's
is in the CSV, so that all mean the same scene. Render: CPU seconds of the render call (Blender: export and BVH
included, saving not; Mitsuba: after compiling its kernels once, BVH left out). Process: those and what the process
takes beside them: `blender -b` of the saved scene to a written picture, by examples/render.py and by Cycles from the
command line; Mitsuba from starting Python to its first sample, kernels from its cache where they are there. Times at
an error are interpolated between the runs around it, log-log; ~: extrapolated beyond them; <: the cheapest run is
better already. Cycles: the faster of fixed and adaptive sampling. Writes peers.csv, peers.md and peers.png.
"""

import csv
import resource
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
from against_cycles import away_from_edges, timed_render  # noqa: E402
from against_cycles import picture as render  # noqa: E402
from helpers import use_cycles_as_reference  # noqa: E402

SCENES = ("open floor", "sphere", "four objects", "plants", "64 lights")
TARGETS = (0.01, 0.005, 0.002)
TOLERANCES = (0.06, 0.02, 0.008, 0.004, 0.002)
SAMPLES = (9, 36, 144, 576, 2304)  # squares, as multi-jittered samples want it
THRESHOLDS = (0.1, 0.03)
LONGEST = 240  # CPU seconds: a run that would take longer, as 4 times the one before, is left out
REFERENCE_POINTS = {"plants": 16384, "64 lights": 256}  # 8192 otherwise
SIZE = (640, 480)
ERRORS = {"relative_rmse": "RMSE", "p99": "P99"}
# The project's goals at 0.2 % RMSE: factors over the faster Cycles and over Mitsuba.
GOALS = {
    "sphere": (80, 7),
    "four objects": (150, 12),
    "plants": (40, 7),
    "64 lights": (200, 15),
    "open floor": (300, 60),
}


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
    width, height = (v * scene.render.resolution_percentage // 100 for v in SIZE)
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
    """All passes of one render, and its CPU seconds."""
    use_cycles_as_reference(scene, samples)
    if threshold is not None:
        scene.cycles.use_adaptive_sampling, scene.cycles.adaptive_threshold = True, threshold
    return timed_render(scene, "CYCLES")


def whole_process(blend_file, engine, folder):
    """CPU seconds of a `blender -b` that renders the saved scene into a file."""
    command, picture = [bpy.app.binary_path, "-b", "--factory-startup", blend_file], folder / "peers_picture"
    if engine == "CYCLES":
        command += ["-E", engine, "-F", "OPEN_EXR", "-t", "1", "-o", f"{picture}#", "-f", "1"]
    else:
        command += ["--python-exit-code", "1", "-P", HERE.parents[1] / "examples" / "render.py"]
        command += ["--", "--output", f"{picture}.exr"]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([str(part) for part in command], check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


def seconds_at(error, runs, key):
    """CPU seconds to an error, and "~" if they are extrapolated, "<" if all runs are better."""
    cheapest = min(runs, key=lambda run: run["cpu_seconds"])
    if max(run[key] for run in runs) <= error:
        return cheapest["cpu_seconds"], "<"
    logs = np.log(sorted((run[key], run["cpu_seconds"]) for run in runs))
    i = int(np.clip(np.searchsorted(logs[:, 0], np.log(error)), 1, len(logs) - 1))
    (x0, y0), (x1, y1) = logs[i - 1], logs[i]
    beyond = not logs[0, 0] <= np.log(error) <= logs[-1, 0]
    return float(np.exp(y0 + (np.log(error) - x0) * (y1 - y0) / (x1 - x0))), "~" if beyond else ""


def measure(name, percentage, python, folder):
    scene = benchmark_scenes.make(name)
    scene.render.resolution_x, scene.render.resolution_y = SIZE
    scene.render.resolution_percentage = percentage
    layer = scene.view_layers[0]
    layer.use_pass_z = layer.use_pass_normal = True
    fixed = {"stop_rule": "FIXED", "light_samples": REFERENCE_POINTS.get(name, 8192), "seed": 4711}
    scene.render.threads_mode = "AUTO"  # its time does not count
    passes, _ = render(scene, fixed, 0)
    scene.render.threads_mode, scene.render.threads = "FIXED", 1
    true, inside = passes["Combined"][..., :3].astype(float), away_from_edges(passes)
    mitsuba = None
    if python != "-":
        export(scene, folder / "peers_scene.npz")
        mitsuba = Mitsuba(python, folder / "peers_scene.npz")
        _, lamp = mitsuba.ask("lamps")
        inside &= lamp[..., 0] == 0
    rows, beside = [], {}

    def add(renderer, setting, pixels, seconds):
        error = (pixels[..., :3].astype(float) - true)[inside]
        row = {"scene": name, "renderer": renderer, "setting": setting, "cpu_seconds": seconds, "beside": 0.0}
        row["relative_rmse"] = np.sqrt((error**2).mean()) / true[inside].mean()
        row["p99"] = np.quantile(np.abs(error).max(-1), 0.99)
        row["mean"] = pixels[..., :3][inside].mean() / true[inside].mean() - 1
        rows.append(row)
        print(" ".join(f"{v:.4g}" if isinstance(v, float) else str(v) for v in row.values()), flush=True)

    def affordable(renderer):
        return 4 * max((r["cpu_seconds"] for r in rows if r["renderer"] == renderer), default=0) < LONGEST

    for i in range(max(len(TOLERANCES), len(SAMPLES))):
        if i < len(TOLERANCES):
            passes, seconds = render(scene, {"error_tolerance": TOLERANCES[i]}, 0)
            add("Penumbra", TOLERANCES[i], passes["Combined"], seconds)
        if i < len(SAMPLES) and affordable("Cycles"):
            passes, seconds = cycles(scene, SAMPLES[i], None)
            add("Cycles", SAMPLES[i], passes["Combined"], seconds)
        if i == 0:  # the scene as it is now, into a file
            blend_file = folder / "peers_scene.blend"
            bpy.ops.wm.save_as_mainfile(filepath=str(blend_file), copy=True, compress=False)
            for own in rows[:2]:
                whole = whole_process(blend_file, own["renderer"].upper(), folder)
                beside[own["renderer"]] = max(whole - own["cpu_seconds"], 0.0)
        if i < len(SAMPLES) and mitsuba and affordable("Mitsuba"):
            seconds, pixels = mitsuba.ask(SAMPLES[i])
            add("Mitsuba", SAMPLES[i], pixels, seconds)
        if i < len(THRESHOLDS) and affordable("Cycles, adaptive"):
            passes, seconds = cycles(scene, 1024, THRESHOLDS[i])
            add("Cycles, adaptive", THRESHOLDS[i], passes["Combined"], seconds)
    if mitsuba:
        beside["Mitsuba"], _ = mitsuba.ask("beside")
        mitsuba.close()
    for row in rows:
        row["beside"] = beside[row["renderer"].partition(",")[0]]
    return rows


def fastest(rows, name, renderer, error, key):
    """(CPU seconds of the render, of the process, mark) of a renderer, the better of its ways of sampling."""
    own = [row for row in rows if row["scene"] == name and row["renderer"].partition(",")[0] == renderer]
    kinds = [[row for row in own if row["renderer"] == kind] for kind in dict.fromkeys(row["renderer"] for row in own)]
    # Not even the adaptive runs need be in order; only what they bracket counts for them.
    found = [(seconds_at(error, runs, key), "," in runs[0]["renderer"]) for runs in kinds]
    (seconds, mark), _ = min(item for item in found if not (item[1] and item[0][1] == "~"))
    return seconds, seconds + own[0]["beside"], mark


def told(value):
    """Two digits."""
    return f"{float(f'{value:.2g}'):g}"


def table(rows):
    """Markdown: seconds and factors at each error; the goals, where there are some, in brackets."""
    peers = [r for r in ("Cycles", "Mitsuba") if any(row["renderer"] == r for row in rows)]
    head = ["scene", "error", "Penumbra", *(cell for peer in peers for cell in (peer, "factor"))]
    head += ["processes: Penumbra", *peers]
    lines = [f"| {' | '.join(head)} |", "|" + "---|" * len(head)]
    for name in dict.fromkeys(row["scene"] for row in rows):
        for key, label in ERRORS.items():
            for target in TARGETS:
                ours, process, own_mark = fastest(rows, name, "Penumbra", target, key)
                cells, processes = [f"{own_mark}{told(ours)} s"], [f"{own_mark}{told(process)} s"]
                for k, peer in enumerate(peers):
                    seconds, whole, mark = fastest(rows, name, peer, target, key)
                    goal = f" ({GOALS[name][k]})" if (key, target) == ("relative_rmse", 0.002) and name in GOALS else ""
                    guess = "~" if "~" in mark + own_mark else ""
                    cells += [f"{mark}{told(seconds)} s", f"{guess}{told(seconds / ours)}x{goal}"]
                    processes.append(f"{mark}{told(whole)} s")
                lines.append(f"| {name} | {label} {target:.1%} | {' | '.join(cells + processes)} |")
    return lines


def plot(rows, path):
    """One panel a scene."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    names = list(dict.fromkeys(row["scene"] for row in rows))
    figure, panels = pyplot.subplots(1, len(names), figsize=(4 * len(names), 4), squeeze=False, sharey=True)
    for name, axes in zip(names, panels[0], strict=True):
        for renderer in dict.fromkeys(row["renderer"] for row in rows):
            own = [row for row in rows if (row["scene"], row["renderer"]) == (name, renderer)]
            axes.loglog([r["cpu_seconds"] for r in own], [r["relative_rmse"] for r in own], "o-", label=renderer)
        axes.set_title(name)
        axes.set_xlabel("CPU seconds of the render")
        axes.grid(True, which="both", alpha=0.3)
    panels[0][0].set_ylabel("relative RMSE")
    panels[0][0].legend()
    figure.tight_layout()
    figure.savefig(path, dpi=100)


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
    plot(rows, folder / "peers.png")


if __name__ == "__main__":
    arguments = sys.argv[sys.argv.index("--") + 1 :]
    main(Path(arguments[0]), *arguments[1:3], *([arguments[3:]] if arguments[3:] else []))
