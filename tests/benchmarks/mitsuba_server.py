# SPDX-License-Identifier: GPL-3.0-or-later
"""Mitsuba 3 as a peer: reads a scene that peers.py exported, then a number of samples a line from standard input.

Writes each picture beside the scene (.npy) and its CPU seconds to standard output. Mitsuba's own `direct` integrator
with one sample of an emitter and none of the BSDF, through each pixel's centre; llvm_ad_rgb on one thread, or
scalar_rgb where LLVM is missing. "lamps": 1 where a pixel shows a lamp.
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

PASS = 16  # samples at a time

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
count = width * height


def rays(copies):
    flat = np.repeat(directions.reshape(-1, 3), copies, axis=0).astype(np.float32)
    eye = data["eye"].astype(np.float32)
    return mi.RayDifferential3f(mi.Point3f(*[float(v) for v in eye]), mi.Vector3f(flat.T.copy()))


def samples(number, seed):
    """Sum over `number` samples a pixel."""
    sampler = mi.load_dict({"type": "independent", "sample_count": number})
    sampler.seed(seed, count * number)
    value, _, _ = integrator.sample(scene, sampler, rays(number))
    return np.array(value).reshape(3, count, number).sum(-1).T.reshape(height, width, 3)


samples(min(PASS, 8), 0)  # compiles the kernels
samples(PASS, 0)
for line in sys.stdin:
    if line.strip() == "lamps":
        hit = scene.ray_intersect(rays(1))
        emitter = np.array(dr.select(hit.is_valid() & (hit.emitter(scene) != None), 1.0, 0.0))  # noqa: E711
        picture, seconds = emitter.reshape(height, width, 1), 0.0
    else:
        wanted, start = int(line), time.process_time()
        picture = np.zeros((height, width, 3))
        for first in range(0, wanted, PASS):
            picture += samples(min(PASS, wanted - first), 1 + first)
        picture, seconds = picture / wanted, time.process_time() - start
    np.save(path.with_suffix(".npy"), picture.astype(np.float32))
    print(seconds, flush=True)
