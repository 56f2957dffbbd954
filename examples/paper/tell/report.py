# SPDX-License-Identifier: GPL-3.0-or-later
"""Puts the chapters together: report.md, and report.html by Python-Markdown."""

import json
from pathlib import Path

import markdown
from tables import Data

from . import bounded, convergence, found, points, shadows, surfaces

STYLE = """
body { max-width: 62rem; margin: 2rem auto; padding: 0 1rem; font: 16px/1.5 system-ui, sans-serif; color: #222 }
img { max-width: 100%; display: block; margin: 1.2rem auto .3rem }
em { color: #555 } h1, h2, h3 { line-height: 1.2; margin-top: 2rem }
table { border-collapse: collapse; margin: 1rem 0; font-size: .85rem; display: block; overflow-x: auto }
th, td { border-bottom: 1px solid #ddd; padding: .25rem .6rem } th { text-align: left; border-bottom: 2px solid #999 }
code { background: #f3f3f3; padding: 0 .2em }
"""


def write(data: Data, folder: Path) -> None:
    text = "\n".join([
        introduction(data), found.tell(data), points.tell(data), shadows.tell(data), convergence.tell(data),
        bounded.tell(data), surfaces.tell(data), left_out(),
    ])  # fmt: skip
    (folder / "report.md").write_text(text, encoding="utf-8")
    body = markdown.markdown(text, extensions=["tables"], output_format="html5")
    page = f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>The paper, reproduced</title>' \
           f"<style>{STYLE}</style></head>\n<body>\n{body}\n</body></html>\n"  # fmt: skip
    (folder / "report.html").write_text(page, encoding="utf-8")


def introduction(data: Data) -> str:
    run = json.loads((data.folder / "run.json").read_text(encoding="utf-8"))
    seconds = ", ".join(f"{name.replace('_', ' ')} {s:.0f} s" for name, s in run["seconds"].items())
    return f"""# The paper, reproduced

R. Ohbuchi and M. Aono, "Quasi-Monte Carlo rendering with low-discrepancy sequences" (IBM Tokyo Research Laboratory,
1990s), asks which points on a luminaire make the best soft shadows, and proposes to stop adding points when the
running mean has come to rest. This report runs its experiments again with Penumbra inside Blender. Every number and
figure comes from this run: the numbers are in `data/*.csv`, the figures in `figures/`.

Errors are in display units: 1 is the brightest unshadowed pixel of the scene. "Exact" is a closed form, "converged" a
picture with tens of thousands of points whose own error is stated. Where the paper leaves something open, the text
says what was chosen.

Run: size {run["size"]}, Penumbra {run["version"]} ({run["build"]}), {run["machine"]}; {seconds}.
"""


def left_out() -> str:
    return """## What is not here

- Faure and generalised Niederreiter sequences, which the paper names without trying them. Faure's two-dimensional
  sequence is in base 2 and is the (0,2)-sequence under Owen-Sobol': its row "same" is that sequence, scrambled once
  for the whole picture. A sampler of its own would add little but a name.
- Several reflections and radiosity, the paper's future work.
- The paper's own scenes and machine: their measures are not in it.
"""
