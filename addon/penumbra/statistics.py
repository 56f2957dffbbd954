# SPDX-License-Identifier: GPL-3.0-or-later
"""What a render did: the native figures completed, merged over view layers, written as JSON and as metadata."""

import json
import os
import sys
from pathlib import Path

import bpy

last_render: dict | None = None
"""The statistics of the last final render in this session, for the panel."""

FIRST_SHARE, FIRST_SECONDS = 0.02, 1.0
"""From this share of the pixels and after this time on the time left can be told."""

SUMS = (
    "triangles", "instances", "luminaires", "meshes", "primary_rays", "mirror_rays", "shadow_rays",
    "shadow_rays_beyond_stop", "points_without_ray", "light_points", "pixels_at_sample_limit", "non_finite_pixels",
)  # fmt: skip
"""The figures that add up over view layers."""


def peak_memory() -> int:
    """The most memory this process (Blender and Penumbra together) has held so far, in bytes; 0 where unknown."""
    try:
        import resource
    except ImportError:  # Windows
        return 0
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else peak * 1024


def time_left(done: float, seconds: float) -> str:
    """What is left of a render of which a share was done in some seconds; nothing before that can be told."""
    if not (FIRST_SHARE <= done < 1 and seconds >= FIRST_SECONDS):
        return ""
    left = seconds * (1 - done) / done
    if left < 60:
        return f"about {max(left, 1):.0f} s left"
    minutes = round(left / 60)
    return f"about {minutes} min left" if minutes < 120 else f"about {minutes / 60:.0f} h left"


def progress_line(done: float, error: float, seconds: float = 0.0) -> str:
    """How far a render is after some seconds: the share of the pixels done, the time left, and what nearly all of the
    pixels done may still be off by."""
    line = ", ".join(filter(None, [f"{100 * done:.0f} % of the pixels done", time_left(done, seconds)]))
    return f"{line}, 99 % of those done with an estimated error below {error:.2g}" if error > 0 else line


def of_view_layer(native: dict, seconds: dict[str, float], notes: list[str], cancelled: bool) -> dict:
    """The statistics of one view layer: `native` from the native renderer, completed by what only the add-on knows."""
    return native | {
        "seconds": {"export": seconds["export"], **native["seconds"], "return": seconds["return"]},
        "peak_memory_bytes": peak_memory(),
        "warnings": notes,
        "cancelled": cancelled,
    }


def merge(layers: dict[str, dict]) -> dict:
    """The statistics of a frame from those of its view layers, by name.

    Counts and seconds are summed; the estimated error's mean is the layers' mean (they have equally many pixels), its
    99th percentile and maximum are those of the worst layer. Each layer's own are under "view_layers" if there are
    several.
    """
    several = list(layers.values())
    total = dict(several[-1])
    if len(several) == 1:
        return total
    total |= {name: sum(layer[name] for layer in several) for name in SUMS}
    total["seconds"] = {name: sum(layer["seconds"][name] for layer in several) for name in total["seconds"]}
    errors = [layer["error_estimate"] for layer in several]
    total["error_estimate"] = {
        "mean": sum(error["mean"] for error in errors) / len(errors),
        "p99": max(error["p99"] for error in errors),
        "max": max(error["max"] for error in errors),
    }
    total["scene_hash"] = " ".join(str(layer["scene_hash"]) for layer in several)
    total["warnings"] = list(dict.fromkeys(text for layer in several for text in layer["warnings"]))
    total["cancelled"] = any(layer["cancelled"] for layer in several)
    total["view_layers"] = layers
    return total


def metadata(statistics: dict) -> dict[str, str]:
    """The statistics as flat text for a picture's header: penumbra.NAME, nested names joined by points."""
    flat: dict[str, str] = {}

    def walk(prefix: str, value) -> None:
        if isinstance(value, dict):
            for name, inner in value.items():
                walk(f"{prefix}.{name}", inner)
        elif isinstance(value, (list, tuple)):
            flat[prefix] = " | ".join(map(str, value))
        else:
            flat[prefix] = f"{value:.6g}" if isinstance(value, float) else str(value)

    walk("penumbra", {name: value for name, value in statistics.items() if name != "view_layers"})
    return flat


def summary(statistics: dict) -> list[tuple[str, str]]:
    """The figures a person looks at first, as (name, text): for the panel and for examples/render.py."""
    error, seconds = statistics["error_estimate"], statistics["seconds"]
    return [
        ("Seconds", f"{sum(seconds.values()):.2f} ({', '.join(f'{name} {s:.2f}' for name, s in seconds.items())})"),
        ("Rays", f"{statistics['primary_rays']:,} primary, {statistics['shadow_rays']:,} shadow"),
        ("Estimated error", f"mean {error['mean']:.2g}, 99 % below {error['p99']:.2g}, largest {error['max']:.2g}"),
        ("Error tolerance", f"{statistics['error_tolerance']:.2g}"),
        ("At sample limit", f"{statistics['pixels_at_sample_limit']:,} pixels"),
        ("Scene", ", ".join(f"{statistics[name]:,} {name}" for name in ("triangles", "instances", "luminaires"))),
        ("Peak memory", f"{statistics['peak_memory_bytes'] / 2**20:,.0f} MiB"),
    ]  # fmt: skip


def file_path(scene, frame: int) -> Path | None:
    """Where `scene.penumbra.statistics_file` asks for the file: // resolved, #### replaced by the frame number."""
    text = scene.penumbra.statistics_file
    if not text:
        return None
    path = Path(bpy.path.abspath(text))
    hashes = path.name.count("#")
    name = path.name.replace("#" * hashes, f"{frame:0{hashes}d}") if hashes else path.name
    return path.with_name(name)


def check_writable(path: Path) -> None:
    """Raises OSError, before anything is rendered, if the statistics file cannot be written."""
    if not path.parent.is_dir() or not os.access(path.parent, os.W_OK):
        raise OSError(f"statistics_file: the folder {path.parent} does not exist or cannot be written to")


def write(path: Path, statistics: dict) -> None:
    """Writes the JSON file by way of a temporary one: it is either whole or not there."""
    temporary = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    try:
        with open(temporary, "w", encoding="utf-8") as file:
            json.dump(statistics, file, indent=2, ensure_ascii=False, default=str)
            file.write("\n")
            file.flush()
            os.fsync(file.fileno())
        os.replace(temporary, path)
    except OSError as error:
        raise OSError(f"statistics_file: cannot write {path}: {error.strerror or error}") from error
    finally:
        temporary.unlink(missing_ok=True)
