# SPDX-License-Identifier: GPL-3.0-or-later
"""The samplers and their treatments from pixel to pixel, with the names and colours that all pages share."""

from typing import NamedTuple


class Method(NamedTuple):
    """A sampler and how pixels share its points. PRS and SPRS draw anew at each pixel whatever `reuse` says."""

    sampler: str
    reuse: str = "SAME"

    @property
    def settings(self) -> dict[str, str]:
        return {"sampler": self.sampler, "sample_reuse": self.reuse}

    @property
    def label(self) -> str:
        name = NAMES[self.sampler]
        return name if self.sampler in ("PRS", "SPRS") else f"{name}, {self.reuse.lower()}"


NAMES = {
    "PRS": "PRS", "SPRS": "SPRS", "SOBOL": "Sobol'", "HALTON": "Halton", "OWEN_SOBOL": "Owen-Sobol'"
}  # fmt: skip
COLOURS = {
    "PRS": "#c0392b", "SPRS": "#e08e0b", "SOBOL": "#2471a3", "HALTON": "#1e8449", "OWEN_SOBOL": "#6c3483"
}  # fmt: skip
REUSES = ("SAME", "CONTINUED", "ROTATED", "SCRAMBLED")

PRS, SPRS, SOBOL, HALTON = (Method(sampler) for sampler in ("PRS", "SPRS", "SOBOL", "HALTON"))
OWEN_SOBOL = Method("OWEN_SOBOL", "SCRAMBLED")
ALL = [PRS, SPRS] + [Method(sampler, reuse) for sampler in ("SOBOL", "HALTON", "OWEN_SOBOL") for reuse in REUSES]
