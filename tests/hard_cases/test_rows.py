# SPDX-License-Identifier: GPL-3.0-or-later
"""Every row of the catalogue of hard cases has a test that carries its number, and README.md's table names them all."""

import re

import pytest
from processes import TESTS

ROOMS = {"a": range(1, 21), "b": range(21, 31), "c": range(31, 36), "d": range(36, 50), "e": range(50, 53)}
"""Luminaire and receiver; visibility; scale and magnitude; bad input; sampler and estimator."""
TABLE = {
    row.lower(): (verdict, set(re.findall(r"`(test_\w+)`", tests)))
    for row, verdict, tests in re.findall(
        r"^\| ([A-E]\d+) \| [^|]+ \| ([^|]+) \| ([^|]+) \|$",
        (TESTS / "hard_cases" / "README.md").read_text(encoding="utf-8"),
        re.MULTILINE,
    )
}


def named_after(row: str) -> set[str]:
    """Names of the tests that carry a row's number, such as a01."""
    files = [path for folder in ("hard_cases", "blender") for path in (TESTS / folder).glob("test_*.py")]
    names = (re.findall(r"^def (test_\w+)\(", path.read_text(encoding="utf-8"), re.MULTILINE) for path in files)
    return {name for found in names for name in found if row in name.split("_")}


@pytest.mark.parametrize(("room", "number"), [(room, number) for room, numbers in ROOMS.items() for number in numbers])
def test_row_has_tests_and_a_verdict(room, number):
    """A verdict that is not plainly "met" tells by what, and how far off the rest is."""
    verdict, tests = TABLE[f"{room}{number}"]
    assert tests == named_after(f"{room}{number:02}") and tests
    assert verdict.startswith("met")


def test_the_table_has_no_other_rows():
    assert len(TABLE) == sum(map(len, ROOMS.values()))
