# SPDX-License-Identifier: GPL-3.0-or-later
"""Puts the built module and this directory's helpers on the path: /usr/bin/python3 -m pytest tests/python."""

import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parents[1] / "addon" / "penumbra")]
