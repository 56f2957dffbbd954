# SPDX-License-Identifier: GPL-3.0-or-later
"""Puts the built module and the helpers of tests/python on the path: /usr/bin/python3 -m pytest tests/hard_cases."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

from processes import PATHS  # noqa: E402  (found through the line above)

sys.path += PATHS
