# SPDX-License-Identifier: GPL-3.0-or-later
"""Mitsuba 3 as a peer: reads a scene that peers.py exported, then a number of samples a line from standard input.

Writes each picture beside the scene (.npy) and its CPU seconds to standard output. Mitsuba's own `direct` integrator
with one sample of an emitter and none of the BSDF, through each pixel's centre, with correlated multi-jittered samples
(2 to 9 times as good as independent ones); llvm_ad_rgb on one thread. "lamps": 1 where a pixel shows a lamp. "beside":
the CPU seconds of the whole process that were not spent on pictures.
"""

import sys
import time
from pathlib import Path

import mitsuba as mi
import numpy as np

try:
    mi.set_variant("llvm_ad_rgb")
    import drjit as dr

    dr.eval(mi.Float(1) + 1)
except Exception:  # no LLVM on this machine
    raise SystemExit("mitsuba_server.py: llvm_ad_rgb needs LLVM's library (Debian: libllvm15)") from None
dr.set_thread_count(1)
mi.set_log_level(mi.LogLevel.Error)  # standard output is for answers

WAVEFRONT = 1 << 22  # samples at a time

path = Path(sys.argv[1])
data = np.load(path)
albedo = {"type": "diffuse", "reflectance": {"type": "rgb", "value": [float(data["albedo"])] * 3}}
parts = {"type": "scene", "integrator": {"type": "direct", "emitter_samples": 1, "bsdf_samples": 0}}
for k in range(int(data["meshes"])):
    positions, triangles = data[f"positions {k}"], data[f"triangles {k}"]
    smooth = f"normals {k}" in data
    mesh = mi.Mesh(f"mesh {k}", len(positions), len(triangles), has_vertex_normals=smooth, props=mi.Properties())
    values = mi.traverse(mesh)
    values["vertex_positions"] = positions.astype(np.float32).ravel()
    values["faces"] = triangles.astype(np.uint32).ravel()
    if smooth:
        values["vertex_normals"] = data[f"normals {k}"].astype(np.float32).ravel()
    values.update()
    mesh.set_bsdf(mi.load_dict(albedo))
    parts[f"mesh {k}"] = mesh
for k, lamp in enumerate(data["lamps"]):
    matrix, size, radiance = lamp[:16].reshape(4, 4), lamp[16], lamp[17]
    # Mitsuba's rectangle spans -1 ... 1 and shines along its +z.
    half = np.diag([size / 2, -size / 2, -size / 2, 1.0])
    parts[f"lamp {k}"] = {
        "type": "rectangle",
        "to_world": mi.ScalarTransform4f(matrix @ half),
        "emitter": {"type": "area", "radiance": {"type": "rgb", "value": [float(radiance)] * 3}},
    }
scene = mi.load_dict(parts)
integrator = scene.integrator()
directions = data["directions"]
height, width, _ = directions.shape


def rays(copies, rows=slice(None)):
    flat = np.repeat(directions[rows].reshape(-1, 3), copies, axis=0).astype(np.float32)
    eye = data["eye"].astype(np.float32)
    return mi.RayDifferential3f(mi.Point3f(*[float(v) for v in eye]), mi.Vector3f(flat.T.copy()))


def picture_of(number, seed):
    """`number` samples a pixel, all of a pixel's in one wavefront, where they are one stratified set."""
    picture = np.empty((height, width, 3))
    band = max(1, WAVEFRONT // (width * number))
    for first in range(0, height, band):
        rows = slice(first, min(first + band, height))
        pixels = (rows.stop - first) * width
        sampler = mi.load_dict({"type": "multijitter", "sample_count": number})
        sampler.set_samples_per_wavefront(number)
        sampler.seed(seed + first, pixels * number)
        value, _, _ = integrator.sample(scene, sampler, rays(number, rows))
        picture[rows] = np.array(value).reshape(3, pixels, number).mean(-1).T.reshape(-1, width, 3)
    return picture


spent = 0.0  # on pictures that were asked for
picture_of(4, 0)  # compiles the kernels
for line in sys.stdin:
    start = time.process_time()
    seconds, picture = 0.0, np.zeros((height, width, 1))
    if line.strip() == "lamps":
        hit = scene.ray_intersect(rays(1))
        emitter = np.array(dr.select(hit.is_valid() & (hit.emitter(scene) != None), 1.0, 0.0))  # noqa: E711
        picture = emitter.reshape(height, width, 1)
        spent += time.process_time() - start
    elif line.strip() == "beside":
        seconds = time.process_time() - spent
    else:
        picture = picture_of(int(line), 1)
        seconds = time.process_time() - start
        spent += seconds
    np.save(path.with_suffix(".npy"), picture.astype(np.float32))
    print(seconds, flush=True)
