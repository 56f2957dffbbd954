# SPDX-License-Identifier: GPL-3.0-or-later
"""Render.debug_pixel: what it tells is what the picture shows, and pixels that fail name themselves."""

import re
import signal as signals

import numpy as np
import penumbra_native as pn
import pytest
from methods import COMBINATIONS
from processes import run_code
from scenes import add, lit_floor, parallelogram, render, translation

SIZE = {"width": 24, "height": 20}


def scene():
    """A half covered luminaire, one in front of it that is wholly seen, one behind the floor."""
    made = lit_floor(albedo=0.3)
    add(made, "plate", parallelogram([0, -4, 1], [4, 0, 0], [0, 8, 0]))
    made.add_area_light("side", "ELLIPSE", translation(-1, 0, 1.5), (0.5, 0.5), (2, 1, 1))
    made.add_area_light("below", "RECTANGLE", translation(0, 0, -1), (1, 1), (1, 1, 1))
    return made


def told(settings, x, y):
    return pn.Render(scene(), {**SIZE, **settings}).debug_pixel(x, y)


@pytest.mark.parametrize("name", COMBINATIONS)
def test_it_tells_what_the_picture_shows(name):
    """The value of the pixel in six digits; each luminaire with points and estimate, and the sum of these is the value,
    but for the antialiased centre fit."""
    settings = {"light_samples": 64, **COMBINATIONS[name]}
    picture = render(scene(), **SIZE, **settings)
    for x, y in ((11, 10), (4, 3), (0, 0), (23, 19)):
        text = told(settings, x, y)
        red = float(re.search(r"Combined ([^,]+),", text)[1])
        assert red == pytest.approx(picture.red[y, x], rel=1e-5)
        assert text.startswith(f"pixel {x},{y} (") and text.count("luminaire '") == 3
        assert "luminaire 'below'" in text and "16 points ----------------" in text
        estimates = [float(value) for value in re.findall(r"estimate \(([^,]+),", text)]
        if "antialiased" not in name:
            assert sum(estimates) == pytest.approx(red, rel=1e-4)


def test_the_mask_is_the_luminaires_points():
    """Under the middle of the half covered luminaire half of the 16 points are seen."""
    mask = re.search(r"'key'.* 16 points ([#.-]{16})", told({"stop_rule": "FIXED"}, 11, 10))[1]
    assert 4 <= mask.count("#") <= 12 and mask.count("#") + mask.count(".") == 16


def test_pixels_that_are_not_finite_name_themselves():
    broken = lit_floor((1e300,) * 3)
    settings = {**SIZE, "stop_rule": "FIXED"}
    warning = render(broken, **settings).statistics["warnings"][0]
    x, y = map(int, re.search(r"pixel (\d+),(\d+) ", warning).groups())
    assert f"not finite: pixel {x // 8 * 8},{y // 8 * 8} (floor)" in pn.Render(broken, settings).debug_pixel(x, y)


def test_refusals():
    job = pn.Render(scene(), {**SIZE, "region": (4, 4, 8, 8)})
    for x, y in ((3, 4), (12, 4), (4, 12), (2**32 - 1, 4)):
        with pytest.raises(ValueError, match=f"debug_pixel: {x},{y} is not in the rendered region"):
            job.debug_pixel(x, y)
    assert "pixel 4,11 (" in job.debug_pixel(4, 11)
    job.start()
    job.finish()
    with pytest.raises(ValueError, match="started already"):
        job.debug_pixel(4, 4)
    assert np.isfinite(job.passes()["Combined"]).all()


@pytest.mark.parametrize("signal", ["SIGSEGV", "SIGABRT"])
def test_a_crash_names_its_pixels(signal):
    """A signal to a rendering thread, as its own fault would send it: the process dies of it, and says where. The same
    signal to another thread says nothing of pixels."""
    code = f"""
        import ctypes, os, signal
        import penumbra_native as pn
        from scenes import lit_floor
        job = pn.Render(lit_floor(), dict(width=256, height=256, stop_rule="FIXED", light_samples=2**16, threads=1))
        before = set(os.listdir("/proc/self/task"))
        job.start()
        (thread,) = set(os.listdir("/proc/self/task")) - before
        while job.progress == 0:
            job.wait(0.01)
        ctypes.CDLL(None).syscall(234, os.getpid(), TARGET, signal.{signal})  # tgkill, x86-64
        job.wait(1e9)
    """
    crashed = run_code(code.replace("TARGET", "int(thread)"))
    assert crashed.returncode == -getattr(signals, signal)
    assert re.search(r"Penumbra: crashed in the pixels \d+,\d+ to \d+,\d+; .*--debug-pixel \d+,\d+", crashed.stderr)
    elsewhere = run_code(code.replace("TARGET", "os.getpid()"))
    assert elsewhere.returncode == -getattr(signals, signal) and "Penumbra" not in elsewhere.stderr
