# SPDX-License-Identifier: GPL-3.0-or-later
"""Notes: what the user should know about a render that succeeded.

Printed as `Penumbra note: ...`, kept in the statistics and shown in a panel. Never reported through Blender's own
"WARNING", whose word in the log makes render farms fail the job.
"""


class Notes:
    """Distinct notes in the order they came; the same text is kept once, and printed once unless they are quiet."""

    def __init__(self, is_quiet: bool = False) -> None:
        self._texts: dict[str, None] = {}
        self._is_quiet = is_quiet

    def add(self, text: str) -> None:
        if text not in self._texts:
            self._texts[text] = None
            if not self._is_quiet:
                print(f"Penumbra note: {text}", flush=True)

    @property
    def texts(self) -> list[str]:
        return list(self._texts)
