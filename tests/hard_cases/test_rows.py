# SPDX-License-Identifier: GPL-3.0-or-later
"""Every row of the catalogue of hard cases has a test that carries its number."""

import re

import pytest
from processes import TESTS

ROOMS = {"a": range(1, 21), "b": range(21, 31), "c": range(31, 36), "d": range(36, 50), "e": range(50, 53)}
"""Luminaire and receiver; visibility; scale and magnitude; bad input; sampler and estimator."""


@pytest.mark.parametrize("row", [f"{room}{number:02}" for room, numbers in ROOMS.items() for number in numbers])
def test_row_has_a_test(row):
    files = [*(TESTS / "hard_cases").glob("test_*.py"), TESTS / "blender" / "test_hard_cases.py"]
    names = [name for path in files for name in re.findall(r"^def (test_\w+)\(", path.read_text(), re.MULTILINE)]
    assert any(row in name.split("_") for name in names)
