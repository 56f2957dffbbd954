# SPDX-License-Identifier: GPL-3.0-or-later
"""What a pixel costs as luminaires become many: a table and many_luminaires.csv.

    python3 tests/benchmarks/many_luminaires.py OUTPUT_FOLDER [--check] [COUNT ...]

A hall of 40 x 40 m, 120 boxes, lamps all over its ceiling (area lights or emissive triangles) of the same power in sum;
three regions of 64 x 48 pixels of a 768 x 576 frame, BOUNDED, one thread. CPU microseconds and shadow rays a pixel: the
least of two rounds, in which all counts take turns. A render's start, the light tree above all, is that of a render of
one pixel; it is left out of the pixel's time and stands apart. --check: share of the pixels of one region that miss the
tolerance, against fixed points on each luminaire (minutes for each thousand luminaires).
"""

import csv
import resource
import sys
import time
from pathlib import Path

import numpy as np

REPOSITORY = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(REPOSITORY / "addon" / "penumbra"), str(REPOSITORY / "tests" / "python")]

import scenes  # noqa: E402
from test_many_luminaires import colour, hall  # noqa: E402

COUNTS, KINDS = (1, 10, 100, 1000, 10_000), ("area", "mesh")
WIDTH, HEIGHT, SIZE = 768, 576, (64, 48)
PARTS = [(64, 64), (320, 256), (576, 448)]
CASES = [(1, 0.02), (1, 0.004), (16, 0.02), (16, 0.004)]  # primary rays a pixel, tolerance
ROUNDS = 2


def render(count, kind, region, **settings):
    """A picture and CPU seconds."""
    scene = hall(count, kind, half=20.0, boxes=120)
    start = time.process_time()
    picture = scenes.render(scene, WIDTH, HEIGHT, region=region, threads=1, **settings)
    return picture, time.process_time() - start


def pixel_cost(count, kind, primaries, tolerance):
    """(microseconds a pixel, shadow rays a pixel, milliseconds to start)."""
    settings = {"stop_rule": "BOUNDED", "error_tolerance": tolerance, "pixel_samples": primaries}
    _, start = render(count, kind, (*PARTS[0], 1, 1), **settings)
    seconds, rays = 0.0, 0
    for part in PARTS:
        picture, spent = render(count, kind, (*part, *SIZE), **settings)
        seconds += spent - start
        rays += picture.statistics["shadow_rays"]
    pixels = len(PARTS) * SIZE[0] * SIZE[1]
    return 1e6 * seconds / pixels, rays / pixels, 1e3 * start


def missed(count, kind, primaries, tolerance):
    points = max(65536 // count, 16) if primaries == 1 else 1
    fixed = {"stop_rule": "FIXED", "light_samples": points, "seed": 4711}
    region = (*PARTS[1], 32, 24)
    true, _ = render(count, kind, region, pixel_samples=1 if primaries == 1 else 1024, **fixed)
    found, _ = render(count, kind, region, stop_rule="BOUNDED", error_tolerance=tolerance, pixel_samples=primaries)
    error = np.abs(colour(found) - colour(true)).max(-1)
    return float((error > tolerance * np.maximum(1, colour(true).max(-1))).mean())


def main(folder, counts, check):
    rows = {}
    for _ in range(ROUNDS):
        for kind in KINDS:
            for primaries, tolerance in CASES:
                for count in counts:
                    key = (kind, primaries, tolerance, count)
                    found = (*pixel_cost(count, kind, primaries, tolerance),
                             resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)  # fmt: skip
                    rows[key] = min(rows.get(key, found), found)
    head = ["kind", "primary_rays", "tolerance", "luminaires", "us_per_pixel", "rays_per_pixel", "start_ms", "peak_mb"]
    lines = []
    for key, found in rows.items():
        lines.append([*key, *(round(v, 2) for v in found)])
        if check:
            lines[-1].append(missed(key[3], *key[:3]))
        print(" ".join(f"{v:>10}" for v in lines[-1]), flush=True)
    if {100, 10_000} <= set(counts):
        for kind in KINDS:
            for case in CASES:
                ratio = rows[(kind, *case, 10_000)][0] / rows[(kind, *case, 100)][0]
                print(f"{kind}, {case[0]} primary rays, {case[1]}: 100 to 10,000 luminaires cost {ratio:.2f} times")
    folder.mkdir(parents=True, exist_ok=True)
    with open(folder / "many_luminaires.csv", "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow([*head, *(["missed"] if check else [])])
        writer.writerows(lines)


if __name__ == "__main__":
    arguments = [a for a in sys.argv[1:] if a != "--check"]
    main(Path(arguments[0]), [int(a) for a in arguments[1:]] or COUNTS, "--check" in sys.argv)
