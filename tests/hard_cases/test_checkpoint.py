# SPDX-License-Identifier: GPL-3.0-or-later
"""A render that was killed goes on from its checkpoint: bit for bit the same picture, no finished bucket twice.

Oracle: the same render without a checkpoint and without interruption.
"""

import random
import signal
import subprocess
import time

import numpy as np
import penumbra_native as pn
import pytest
from processes import command, run_code
from scenes import ALL_PASSES, add, lit_floor, sphere

SIZE = {"width": 200, "height": 130, "passes": ALL_PASSES, "threads": 2}
BUCKETS = 4 * 3
RULES = {
    "fixed": {"stop_rule": "FIXED", "light_samples": 256},
    "bounded": {"stop_rule": "BOUNDED", "error_tolerance": 0.002},
    "antialiased": {"stop_rule": "BOUNDED", "pixel_samples": 4, "error_tolerance": 0.02},
    "border": {"stop_rule": "FIXED", "region": (11, 7, 150, 101)},
}


def make():
    scene = lit_floor()
    add(scene, "ball", sphere([0, 0, 0.6], 0.5, 24))
    return scene


def run(folder, stop_after=None, scene=None, **settings):
    """Renders with a checkpoint; with `stop_after` it is cancelled once so many buckets are finished."""
    job = pn.Render(scene or make(), {**SIZE, "checkpoint": str(folder), **settings})
    job.start()
    finished = 0
    while not job.done:
        finished += len(job.wait(1.0))
        if stop_after is not None and finished >= stop_after:
            job.cancel()
    job.finish()
    return job


def whole(**settings):
    job = pn.Render(make(), {**SIZE, **settings})
    job.start()
    job.finish()
    return job


def counts(job):
    """What a render did, but for the time it took."""
    return {name: value for name, value in job.statistics().items() if name != "seconds"}


def assert_equal(job, reference):
    for name, values in reference.passes().items():
        assert job.passes()[name].tobytes() == values.tobytes(), name


@pytest.mark.parametrize("rule", RULES)
def test_a_cancelled_render_goes_on(tmp_path, rule):
    first = run(tmp_path, stop_after=3, **RULES[rule])
    kept = {path: path.stat().st_mtime_ns for path in tmp_path.glob("bucket_*.bin")}
    assert len(kept) >= 3 and first.statistics()["primary_rays"] > 0
    second, reference = run(tmp_path, **RULES[rule]), whole(**RULES[rule])
    assert_equal(second, reference)
    assert counts(second) == counts(reference)
    assert {path: path.stat().st_mtime_ns for path in kept} == kept, "a finished bucket was rendered again"
    assert not list(tmp_path.glob("*.tmp"))


def test_a_finished_render_traces_nothing_again(tmp_path):
    run(tmp_path, **RULES["fixed"])
    job = pn.Render(make(), {**SIZE, "checkpoint": str(tmp_path), **RULES["fixed"]})
    assert not job.done
    assert job.progress == 1.0
    job.start()
    assert len(job.wait(0.0)) == BUCKETS and job.done
    job.finish()
    assert_equal(job, whole(**RULES["fixed"]))
    assert job.statistics()["seconds"]["render"] == 0


VICTIM = "import test_checkpoint as t\nt.run({folder!r}, **t.RULES[{rule!r}])"


@pytest.mark.parametrize("rule", ["fixed", "antialiased"])
def test_kill_9_at_random_moments(tmp_path, rule):
    """Again and again, up to 50 ms after the first new bucket, until it gets through."""
    moments = random.Random(8)
    victim = command(VICTIM.format(folder=str(tmp_path), rule=rule))
    seen, kills = {}, 0
    for _ in range(BUCKETS + 1):
        process = subprocess.Popen(victim, stderr=subprocess.PIPE)
        while process.poll() is None and len(list(tmp_path.glob("bucket_*.bin"))) <= len(seen):
            time.sleep(1e-3)
        time.sleep(moments.uniform(0, 0.05))
        process.kill()
        errors = process.communicate()[1]
        assert process.returncode in (0, -signal.SIGKILL), errors.decode()
        now = {path: path.stat().st_mtime_ns for path in tmp_path.glob("bucket_*.bin")}
        assert {path: now[path] for path in seen} == seen, "a finished bucket was rendered again"
        seen, kills = now, kills + (process.returncode != 0)
        if process.returncode == 0:
            break
    assert kills > 0 and len(seen) == BUCKETS
    assert_equal(run(tmp_path, **RULES[rule]), whole(**RULES[rule]))


@pytest.mark.parametrize("damage", ["cut", "longer", "one bit", "empty", "of another bucket"])
def test_damaged_buckets_are_rendered_again(tmp_path, damage):
    run(tmp_path, **RULES["fixed"])
    paths = sorted(tmp_path.glob("bucket_*.bin"))
    assert len(paths) == BUCKETS
    content = paths[5].read_bytes()
    changed = bytearray(content)
    changed[len(content) // 2] ^= 16
    paths[5].write_bytes({
        "cut": content[:-100], "longer": content + b"\0" * 8, "one bit": bytes(changed), "empty": b"",
        "of another bucket": paths[4].read_bytes(),
    }[damage])  # fmt: skip
    assert_equal(run(tmp_path, **RULES["fixed"]), whole(**RULES["fixed"]))
    assert paths[5].read_bytes() == content


def test_other_renders_are_refused(tmp_path):
    run(tmp_path, stop_after=1, **RULES["fixed"])
    files = {path: path.read_bytes() for path in tmp_path.iterdir()}
    other = make()
    other.add_area_light("fill", "RECTANGLE", np.eye(4), (1, 1), (1, 1, 1))
    for words, change in (
        ("another scene", {"scene": other}),
        ("another set of settings", {"light_samples": 257}),
        ("another set of settings", {"width": 199}),
        ("another set of settings", {"passes": ["Combined"]}),
    ):
        with pytest.raises(ValueError, match=f"checkpoint: .* cannot be continued: it is of {words}"):
            run(tmp_path, **{**RULES["fixed"], **change})
    description = tmp_path / "render.txt"
    description.write_text(description.read_text().replace(pn.__version__, "0.0.1"))
    with pytest.raises(ValueError, match="it is of another version"):
        run(tmp_path, **RULES["fixed"])
    assert {path: path.read_bytes() for path in tmp_path.iterdir() if path != description} == {
        path: content for path, content in files.items() if path != description
    }
    run(tmp_path / "new", stop_after=1, threads=1, **RULES["fixed"])
    assert_equal(run(tmp_path / "new", threads=2, **RULES["fixed"]), whole(**RULES["fixed"]))  # threads may differ


def test_folders_that_do_not_fit(tmp_path):
    (tmp_path / "holiday.jpg").touch()
    with pytest.raises(ValueError, match="holds other files"):
        run(tmp_path)
    file = tmp_path / "file"
    file.touch()
    for folder in (file, file / "below"):
        with pytest.raises(RuntimeError, match="cannot be made"):
            run(folder)


def test_a_full_disk_is_an_error(tmp_path):
    """Files may not grow beyond 8 KiB: a bucket of 64 x 64 pixels needs more."""
    process = run_code(
        "import resource, signal\n"
        "signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (8192, 8192))\n" + VICTIM.format(folder=str(tmp_path), rule="fixed")
    )
    assert process.returncode == 1 and "RuntimeError: checkpoint: cannot write" in process.stderr
    assert not list(tmp_path.glob("bucket_*.bin"))
