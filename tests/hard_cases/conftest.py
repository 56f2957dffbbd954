# SPDX-License-Identifier: GPL-3.0-or-later
"""Puts the built module and the helpers of tests/python on the path: /usr/bin/python3 -m pytest tests/hard_cases."""

import sys
from pathlib import Path

TESTS = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(TESTS / "hard_cases"), str(TESTS / "python"), str(TESTS.parent / "addon" / "penumbra")]
