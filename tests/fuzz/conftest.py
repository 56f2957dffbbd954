# SPDX-License-Identifier: GPL-3.0-or-later
"""Puts the built module and the helpers of the other tests on the path; how long to search.

PENUMBRA_FUZZ_EXAMPLES=N looks at N random inputs a test instead of the same few hundred each time.
"""

import os
import sys
from pathlib import Path

from hypothesis import HealthCheck, settings

TESTS = Path(__file__).resolve().parents[1]
# At the end: the add-on has files that are named like the standard library's.
sys.path += [str(TESTS / "python"), str(TESTS.parent / "addon" / "penumbra")]

examples = os.environ.get("PENUMBRA_FUZZ_EXAMPLES")
settings.register_profile(
    "penumbra", deadline=None, database=None, max_examples=int(examples or 200), derandomize=not examples,
    suppress_health_check=list(HealthCheck),
)  # fmt: skip
settings.load_profile("penumbra")
