# SPDX-License-Identifier: GPL-3.0-or-later
"""Puts the built module and this directory's helpers on the path: /usr/bin/python3 -m pytest tests/python."""

import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
# At the end: the add-on has files that are named like the standard library's.
sys.path.append(str(HERE.parents[1] / "addon" / "penumbra"))
