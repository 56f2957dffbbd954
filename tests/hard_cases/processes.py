# SPDX-License-Identifier: GPL-3.0-or-later
"""Python processes of their own, for what must not happen to the one that runs the tests."""

import subprocess
import sys
import textwrap
from pathlib import Path

TESTS = Path(__file__).resolve().parents[1]
PATHS = [str(TESTS / "hard_cases"), str(TESTS / "python"), str(TESTS.parent / "addon" / "penumbra")]
"""For the end of sys.path: the add-on has files that are named like the standard library's."""


def command(code: str) -> list[str]:
    """Runs `code` where the tests' helpers and the module can be imported."""
    return [sys.executable, "-c", f"import sys\nsys.path += {PATHS!r}\n" + textwrap.dedent(code)]


def run_code(code: str, timeout: float = 600) -> subprocess.CompletedProcess:
    return subprocess.run(command(code), capture_output=True, text=True, check=False, timeout=timeout)
