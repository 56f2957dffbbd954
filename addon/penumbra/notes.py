# SPDX-License-Identifier: GPL-3.0-or-later
"""Notes: what the user should know about a render that succeeded.

Printed as `Penumbra note: ...`, kept in the statistics and shown in a panel. Never reported through Blender's own
"WARNING", whose word in the log makes render farms fail the job.
"""


class Notes:
    """Distinct notes in the order they came; the same text is printed and kept once."""

    def __init__(self) -> None:
        self._texts: dict[str, None] = {}

    def add(self, text: str) -> None:
        if text not in self._texts:
            self._texts[text] = None
            print(f"Penumbra note: {text}", flush=True)

    @property
    def texts(self) -> list[str]:
        return list(self._texts)
