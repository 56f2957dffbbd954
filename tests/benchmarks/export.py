# SPDX-License-Identifier: GPL-3.0-or-later
"""What it takes to get a scene from Blender and a picture back: a table and export.csv.

    blender -b --factory-startup --python-exit-code 1 -P tests/benchmarks/export.py -- OUTPUT_FOLDER

CPU milliseconds, the best of a few runs. What Blender itself computes on demand (triangles, normals) stands apart. The
goals are the project's: 60 ms for 2 million triangles, 100 ms for 10,000 instances, 30 ms for a picture of 1920 x 1080,
and 1 s for all that a process does beside Blender's own start and the render.
"""

import csv
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import bpy
import numpy as np

REPOSITORY = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(REPOSITORY / "addon"))

import penumbra  # noqa: E402  (found through the line above)
from penumbra import in_place, native, passes  # noqa: E402
from penumbra.export import export_scene, meshes  # noqa: E402
from penumbra.notes import Notes  # noqa: E402

SIDE, RUNS, INSTANCES = 1000, 5, 10_000
rows: list[tuple[str, float, str]] = []


def cpu_ms(work, runs=RUNS, prepare=lambda: None) -> float:
    """The least CPU time of several runs of `work`, which gets what `prepare` returns."""
    times = []
    for _ in range(runs):
        given = prepare()
        arguments = () if given is None else (given,)
        start = time.process_time()
        work(*arguments)
        times.append(1e3 * (time.process_time() - start))
    return min(times)


def row(what: str, milliseconds: float, goal: str = "") -> None:
    rows.append((what, milliseconds, goal))
    print(f"export: {what:66} {milliseconds:9.1f} ms  {goal}", flush=True)


def bumpy_grid(smooth: bool):
    """A mesh of 2 SIDE^2 triangles in quads."""
    x, y = (a.ravel() for a in np.meshgrid(*[np.linspace(-1, 1, SIDE + 1, dtype=np.float32)] * 2))
    positions = np.stack([x, y, 0.1 * np.sin(9 * x) * np.cos(7 * y)], axis=-1).astype(np.float32)
    corner = (np.arange(SIDE)[:, None] * (SIDE + 1) + np.arange(SIDE)).ravel()
    quads = np.stack([corner, corner + 1, corner + SIDE + 2, corner + SIDE + 1], axis=-1).astype(np.int32)
    mesh = bpy.data.meshes.new("Grid")
    mesh.vertices.add(len(positions))
    mesh.vertices.foreach_set("co", positions.ravel())
    mesh.loops.add(quads.size)
    mesh.loops.foreach_set("vertex_index", quads.ravel())
    mesh.polygons.add(len(quads))
    mesh.polygons.foreach_set("loop_start", np.arange(0, quads.size, 4, dtype=np.int32))
    if hasattr(bpy.types.MeshPolygon.bl_rna.properties["loop_total"], "is_readonly") and \
            not bpy.types.MeshPolygon.bl_rna.properties["loop_total"].is_readonly:  # fmt: skip
        mesh.polygons.foreach_set("loop_total", np.full(len(quads), 4, dtype=np.int32))
    mesh.update(calc_edges=True)
    mesh.polygons.foreach_set("use_smooth", np.full(len(quads), smooth))
    mesh.update()
    return mesh


def empty_scene():
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    scene.render.engine = "PENUMBRA"
    light = bpy.data.objects.new("Light", bpy.data.lights.new("Light", "AREA"))
    light.location.z = 4
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location.z = 5
    scene.camera = camera
    for thing in (light, camera):
        scene.collection.objects.link(thing)
    return scene


def measure_mesh(smooth: bool) -> None:
    scene, kind = empty_scene(), "smooth" if smooth else "flat"
    thing = bpy.data.objects.new("Grid", bumpy_grid(smooth))
    scene.collection.objects.link(thing)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    evaluated = thing.evaluated_get(depsgraph)
    mesh, pn = evaluated.data, native.require()
    count = 2 * SIDE**2
    title = f"{count / 1e6:.0f} M triangles, {kind}"
    if not smooth:
        row(f"{title}: Blender's to_mesh (not used)", cpu_ms(lambda: evaluated.to_mesh(), 1))
        evaluated.to_mesh_clear()
    start = time.process_time()
    mesh.calc_loop_triangles()
    row(f"{title}: Blender's loop triangles", 1e3 * (time.process_time() - start))
    if smooth:
        start = time.process_time()
        normals = mesh.corner_normals if hasattr(mesh, "corner_normals") else mesh.vertex_normals
        assert len(normals[0].vector) == 3  # computed on demand
        row(f"{title}: Blender's normals", 1e3 * (time.process_time() - start))
        if hasattr(mesh, "calc_normals_split"):
            row(f"{title}: Blender's split normals (auto smooth only)", cpu_ms(mesh.calc_normals_split, 1))
    read = cpu_ms(lambda: meshes.read_mesh(mesh))
    arrays = meshes.read_mesh(mesh)
    added = cpu_ms(lambda scene: scene.add_mesh("Grid", *arrays), prepare=pn.Scene)
    row(f"{title}: Blender's arrays read in place", read)
    row(f"{title}: the native scene's copy, checked and hashed", added)
    row(f"{title}: both", read + added, "goal 60")
    kept_view, in_place.view = in_place.view, lambda collection, name: None
    row(f"{title}: read by foreach_get instead", cpu_ms(lambda: meshes.read_mesh(mesh), 2))
    in_place.view = kept_view


def measure_instances() -> None:
    scene = empty_scene()
    source = bpy.data.meshes.new("Triangle")
    source.from_pydata([(0, 0, 0), (0.01, 0, 0), (0, 0.01, 0)], [], [(0, 1, 2)])
    collection = bpy.data.collections.new("Row")
    for i in range(100):
        thing = bpy.data.objects.new(f"Triangle {i}", source)
        thing.location.x = i / 50 - 1
        collection.objects.link(thing)
    for i in range(INSTANCES // 100):
        empty = bpy.data.objects.new(f"Row {i}", None)
        empty.instance_type, empty.instance_collection, empty.location.y = "COLLECTION", collection, i / 50 - 1
        scene.collection.objects.link(empty)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    pn, camera = native.require(), scene.camera.evaluated_get(depsgraph)
    row(f"{INSTANCES:,} instances: Blender's iteration over them",
        cpu_ms(lambda: sum(1 for _ in depsgraph.object_instances)))  # fmt: skip
    row(f"{INSTANCES:,} instances: the whole export",
        cpu_ms(lambda: export_scene(pn, depsgraph, camera, Notes())), "goal 100")  # fmt: skip


def measure_picture() -> None:
    """All passes that are on by default: 4 + 1 + 1 floats a pixel."""
    scene = empty_scene()
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 1920, 1080, 100
    scene.penumbra.stop_rule, scene.penumbra.light_samples, scene.penumbra.pixel_samples = "FIXED", 1, 1
    times, merges, write_bucket = [], [], passes.write_bucket

    class Engine:
        """Blender's, whose own part is told apart: it copies a finished result into its own."""

        def __init__(self, engine):
            self.begin_result, self._engine = engine.begin_result, engine

        def end_result(self, *arguments, **named):
            start = time.process_time()
            self._engine.end_result(*arguments, **named)
            merges.append(1e3 * (time.process_time() - start))

    def measured(engine, *arguments, **named):
        start = time.process_time()
        write_bucket(Engine(engine), *arguments, **named)
        times.append(1e3 * (time.process_time() - start))

    passes.write_bucket = measured
    for _ in range(RUNS):
        bpy.ops.render.render(scene=scene.name)
    passes.write_bucket = write_bucket
    row("1920 x 1080, all passes: pixels back to Blender", min(times), "goal 30")
    row("1920 x 1080, all passes: of these, Blender's end_result", min(merges))


def measure_process() -> None:
    """User and system time of whole processes on the example scene, where the render is next to nothing: one point and
    one ray a pixel. All that remains is enabling, exporting, writing the picture, reading it back, and leaving."""
    blend = REPOSITORY / "examples" / "four_objects.blend"
    if not blend.exists():
        command = [bpy.app.binary_path, "-b", "--factory-startup", "-P", str(blend.with_name("make_four_objects.py"))]
        subprocess.run(command, check=True, capture_output=True)

    def process_ms(*arguments) -> float:
        before = os.times()
        subprocess.run([bpy.app.binary_path, "-b", "--factory-startup", "--python-exit-code", "1", str(blend),
                        *map(str, arguments)], check=True, capture_output=True)  # fmt: skip
        after = os.times()
        return 1e3 * (after.children_user - before.children_user + after.children_system - before.children_system)

    start_ms = min(process_ms() for _ in range(3))
    with tempfile.TemporaryDirectory() as folder:
        options = ["-P", REPOSITORY / "examples" / "render.py", "--", "--output", Path(folder) / "out.exr"]
        options += ["--set", "stop_rule=FIXED", "light_samples=1", "pixel_samples=1"]
        whole_ms = min(process_ms(*options) for _ in range(3))
    row("the example: Blender's own start with the file", start_ms)
    row("the example: whole process beyond that, one ray and point a pixel", whole_ms - start_ms, "goal 1000")


def main() -> None:
    folder = Path(sys.argv[sys.argv.index("--") + 1])
    folder.mkdir(parents=True, exist_ok=True)
    penumbra.register()
    measure_mesh(smooth=False)
    measure_mesh(smooth=True)
    measure_instances()
    measure_picture()
    measure_process()
    with open(folder / "export.csv", "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["what", "milliseconds", "goal"])
        writer.writerows(rows)


main()
