# SPDX-License-Identifier: GPL-3.0-or-later
"""The native module as a file: what it exports, which instructions it holds, which CPUs it runs on."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import penumbra_native
import pytest
from scenes import lit_floor, render

REPOSITORY = Path(__file__).resolve().parents[2]
MODULE = Path(penumbra_native.__file__)
WIDE = re.compile(r":\s+v[a-z]")
"""An instruction of AVX or later: their names start with v, and none of x86-64-v2's does."""
CLONE = re.compile(r"\.arch_x86_64_v[34]\b")


def output_of(*command) -> str:
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def test_only_the_init_function_is_exported():
    names = [line.split()[-1] for line in output_of("nm", "-D", "--defined-only", MODULE).splitlines()]
    assert names == ["PyInit_penumbra_native"]


@pytest.mark.skipif("x86" not in MODULE.name, reason="for x86-64")
def test_wide_instructions_are_in_functions_that_the_cpu_chooses():
    """All of AVX and AVX-512 belongs to clones for x86-64-v3 and -v4, of which the loader picks one (math/simd.h)."""
    function, outside, inside = "", set(), 0
    for line in output_of("objdump", "--disassemble", "--no-show-raw-insn", MODULE).splitlines():
        if match := re.match(r"[0-9a-f]+ <(.*)>:$", line):
            function = match[1]
        elif WIDE.search(line):
            inside += 1
            if not CLONE.search(function):
                outside.add(function)
    assert outside == set()
    assert inside > 100 or "GNU" not in penumbra_native.build


PICTURE = """
import sys
sys.path[:0] = {paths!r}
import numpy as np, penumbra_native
from scenes import lit_floor, render
np.save({file!r}, render(lit_floor()).passes["Combined"])
print(penumbra_native.isa)
"""


def on_cpu(cpu: str, script: str) -> subprocess.CompletedProcess:
    """Runs a Python script on an emulated CPU; the test is skipped without qemu-user."""
    if not shutil.which("qemu-x86_64"):
        pytest.skip("no qemu-x86_64 (Debian: apt-get install qemu-user)")
    command = ["qemu-x86_64", "-cpu", cpu, sys.executable, "-c", script]
    # What OpenBLAS, which NumPy loads, is told about the real CPU does not hold for this one.
    environment = {name: value for name, value in os.environ.items() if not name.startswith("OPENBLAS_")}
    return subprocess.run(command, capture_output=True, text=True, check=False, env=environment)


@pytest.mark.skipif("x86" not in MODULE.name, reason="for x86-64")
@pytest.mark.parametrize(("cpu", "isa"), {"Nehalem": "sse4.2", "Haswell": "avx2"}.items())
def test_picture_on_an_older_cpu(cpu, isa, tmp_path):
    """x86-64-v2 and -v3: any instruction beyond them ends the process. The floor's picture agrees within 1e-6.

    Embree has code of its own for each CPU and its hits differ by some ulps; ours is the same on each.
    """
    file, paths = str(tmp_path / "picture.npy"), [str(MODULE.parent), *sys.path]
    process = on_cpu(cpu, PICTURE.format(paths=paths, file=file))
    assert process.returncode == 0, process.stderr
    assert process.stdout.strip() == isa
    np.testing.assert_allclose(np.load(file), render(lit_floor()).passes["Combined"], rtol=1e-6)


@pytest.mark.skipif("x86" not in MODULE.name, reason="for x86-64")
def test_a_cpu_that_is_too_old_is_told_and_nothing_dies(tmp_path):
    """A Core 2 has no SSE 4.2: the import fails, with the sentence of the add-on's preferences."""
    (tmp_path / "addon").mkdir()
    shutil.copy(REPOSITORY / "addon" / "penumbra" / "native.py", tmp_path / "addon")
    shutil.copy(MODULE, tmp_path / "addon")
    script = f"import sys; sys.path[0] = {str(tmp_path)!r}; from addon import native; print(native.reason)"
    process = on_cpu("Conroe", script)
    assert process.returncode == 0, process.stderr
    assert process.stdout.strip().endswith("needs a CPU with SSE 4.2 (x86-64-v2), which this one is not.")
