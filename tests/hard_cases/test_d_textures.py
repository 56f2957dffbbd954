# SPDX-License-Identifier: GPL-3.0-or-later
"""Row 48 in the module: hostile image files. Each is magenta, or what could be read of it, and a note names it; the
process lives. Through Blender: tests/blender/test_hard_cases.py."""

import os
import struct
import zlib

import numpy as np
import penumbra_native as pn
import pytest
from processes import run_code
from scenes import floor, look_down, render

oiio = pytest.importorskip("OpenImageIO")

NAME = "material 'Lack': image 'Plakat'"


def chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def png(width, height, bits, rows):
    """A grey PNG file, whatever its data."""
    header = struct.pack(">IIBBBBB", width, height, bits, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", rows) + chunk(b"IEND", b"")


def tiff(width, height, tile):
    """An image of one tile, of which there are 16 bytes."""
    entries = {256: width, 257: height, 258: 8, 259: 1, 262: 1, 277: 1, 322: tile, 323: tile, 324: 8, 325: 16}
    directory = struct.pack("<H", len(entries))
    directory += b"".join(struct.pack("<HHII", tag, 4, 1, value) for tag, value in sorted(entries.items()))
    return b"II*\0" + struct.pack("<I", 24) + bytes(16) + directory + bytes(4)


def written(path, *shape, **attributes):
    """A good file of that shape (height, width, channels), or depth first."""
    spec = oiio.ImageSpec(shape[-2], shape[-3], shape[-1], oiio.UINT8 if path.suffix == ".jpg" else oiio.FLOAT)
    for name, value in attributes.items():
        spec.attribute(name, value)
    output = oiio.ImageOutput.create(str(path))
    assert output.open(str(path), spec) and output.write_image(np.full(shape, 0.5, np.float32)) and output.close()
    return path.read_bytes()


def poster(path, content=None):
    """A floor that shows the image alone."""
    scene = pn.Scene()
    scene.add_image(NAME, [(1001, str(path), content)])
    steps = [("position", 1, [], 0, 0), ("image", 3, [1], 0, 0)]
    paint = scene.add_program("Lack", np.zeros((6, 3), np.float32), steps, [], [("emission", 3, 0, 0, 0)])
    scene.add_instance("floor", scene.add_mesh("floor", *floor()), np.eye(4), [paint])
    look_down(scene)
    return scene


def assert_missing(scene, reason=""):
    picture = render(scene, 6, stop_rule="FIXED")
    assert (picture.passes["Combined"] == [1, 0, 1, 1]).all()
    (note,) = picture.statistics["warnings"]
    assert note.startswith(NAME + ": ") and reason in note and note.endswith("; rendered in magenta")


@pytest.mark.parametrize("packed", [False, True])
@pytest.mark.parametrize(
    ("name", "content", "reason"),
    [
        ("wide.png", png(65537, 1, 8, zlib.compress(bytes(65538))), "65537 x 1 x 1 pixels of 1 channels, more than"),
        ("high.png", png(1, 100_000, 8, zlib.compress(bytes(200_000))), "1 x 100000 x 1 pixels"),
        ("vast.png", png(2**31 - 1, 2**31 - 1, 8, b""), ""),
        ("none.png", png(0, 0, 8, b""), ""),
        ("tile.tif", tiff(16, 16, 2**20), ""),
        ("tiles.tif", tiff(65536, 65536, 65536), ""),
        ("empty.exr", b"", ""),
        ("text.png", b"#!/bin/sh\nexit 1\n", ""),
        ("header.exr", struct.pack("<II", 20000630, 2) + b"channels\0chlist\0" + b"\xff" * 64, ""),
    ],
)
def test_d48_headers_that_promise_too_much(tmp_path, name, content, reason, packed):
    path = tmp_path / name
    if not packed:
        path.write_bytes(content)
    assert_missing(poster(path, content if packed else None), reason)


def test_d48_too_many_channels(tmp_path):
    written(tmp_path / "many.exr", 4, 4, 200)
    assert_missing(poster(tmp_path / "many.exr"), "4 x 4 x 1 pixels of 200 channels, more than are read")


def test_d48_what_is_no_file(tmp_path):
    """A folder, a pipe that nobody writes to, a device without end: not even opened."""
    os.mkfifo(tmp_path / "pipe.png")
    for path in (tmp_path, tmp_path / "pipe.png", "/dev/zero", tmp_path / "missing.png"):
        assert_missing(poster(path), f"there is no such file: {path}")


@pytest.mark.parametrize("suffix", [".png", ".exr", ".tif", ".jpg", ".hdr"])
@pytest.mark.parametrize("share", [0.02, 0.5, 0.97])
def test_d48_truncated_files(tmp_path, suffix, share):
    path = tmp_path / f"cut{suffix}"
    whole = written(path, 64, 64, 3)
    path.write_bytes(whole[: int(len(whole) * share)])
    picture = render(poster(path), 6, stop_rule="FIXED")
    assert np.isfinite(picture.passes["Combined"]).all()
    assert all(note.startswith(NAME) for note in picture.statistics["warnings"])
    if share == 0.02:
        assert_missing(poster(path))


@pytest.mark.parametrize(
    ("side", "mebibytes", "read"), [(40_000, 512, False), (4000, 150, False), (4000, 190, False), (4000, 400, True)]
)
def test_d48_no_memory_for_an_image(side, mebibytes, read):
    """In a process that may grow by so much more; the pixels of 4000 x 4000 are 15 MiB, and are read from 190 MiB on.
    OpenImageIO 2.4 ends the process where it is tried with less."""
    rows = side if side < 9999 else 1
    process = run_code(f"""
        import pathlib, resource, tempfile, zlib
        import test_d_textures as t
        from scenes import render
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "poster.png"
            path.write_bytes(t.png({side}, {side}, 8, zlib.compress(bytes({side + 1}) * {rows})))
            render(t.poster(pathlib.Path(folder) / "none.png"), 4)
            used = int(open("/proc/self/statm").read().split()[0]) * 4096
            resource.setrlimit(resource.RLIMIT_AS, (used + {mebibytes} * 2**20, -1))
            picture = render(t.poster(path), 4, stop_rule="FIXED", threads=1)
            print(picture.passes["Combined"][0, 0], *picture.statistics["warnings"])
    """)
    assert process.returncode == 0, process.stderr
    refused = "this process cannot get the" in process.stdout or "malicious header" in process.stdout  # OIIO 3.1's own
    assert refused == (not read), process.stdout
    assert process.stdout.startswith("[0. 0. 0. 1.]" if read else "[1. 0. 1. 1.]")
