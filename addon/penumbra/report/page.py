# SPDX-License-Identifier: GPL-3.0-or-later
"""The files of a report: a page that needs nothing beside it, the same pictures as PNG, the figures as CSV and JSON."""

import base64
import csv
import json
import math
from html import escape
from pathlib import Path

from . import folder, plots
from .page_text import HEAD, table, verdicts
from .study import Picture, Study

NAME, TABLE, PLOT, REFERENCE = "report.html", "figures.csv", "speed_against_error.png", "reference.png"
ANTIALIASED = """ The error is that of the filtered pixel: PAPER and VARIANCE trace your number of primary rays, so that
their error at edges stays."""
FORMAT = "penumbra speed against error, 1"


def shown_pictures(study: Study) -> dict[str, Picture]:
    """The runs whose images are shown, by the word in their files' names.

    BOUNDED at the user's tolerance; the user's own settings if they are others; and of the fixed points and of Cycles
    those that took nearest as long.
    """
    tolerance = study.own["error_tolerance"]

    def of(family: str) -> list[Picture]:
        return [picture for picture in study.pictures if picture.row["family"] == family]

    def nearest(pictures: list[Picture], column: str, value: float) -> Picture | None:
        return min(pictures, key=lambda p: abs(math.log(p.row[column] / value)), default=None)

    bounded = nearest(of("BOUNDED, OWEN_SOBOL"), "tolerance", tolerance)
    seconds = bounded.row["seconds"]
    found = {
        "bounded": bounded,
        "own": next(picture for picture in study.pictures if picture.row["own_settings"]),
        "paper": nearest(of("PAPER, OWEN_SOBOL"), "tolerance", tolerance),
        "fixed": nearest(of("FIXED, OWEN_SOBOL"), "seconds", seconds),
        "cycles": nearest(of("Cycles"), "seconds", seconds),
    }
    different: dict[str, Picture] = {}
    for word, picture in found.items():
        if picture is not None and not any(picture is other for other in different.values()):
            different[word] = picture
    return different


def write(study: Study, target: Path) -> None:
    """Writes all files into the folder `target`."""
    plots.speed_against_error(study, target / PLOT)
    plots.reference_image(study, target / REFERENCE)
    pictures = shown_pictures(study)
    figures = []
    for word, picture in pictures.items():
        files = [target / f"error_{word}.png"]
        plots.error_image(picture, files[0])
        if picture.samples is not None:
            files.append(target / f"samples_{word}.png")
            plots.sample_image(picture, files[1])
        figures.append((picture, files))
    write_csv(study.rows, target / TABLE)
    (target / NAME).write_text(html(study, target, figures), encoding="utf-8")
    manifest = {
        "format": FORMAT,
        "facts": dict(study.facts),
        "notes": study.notes,
        "settings": study.own,
        "reference": {
            "description": study.reference.description,
            "error_p99": study.reference.error_p99,
            "error_rmse": study.reference.error_rmse,
            "settings": study.reference.settings,
        },
        "rows": study.rows,
        "files": sorted({path.name for path in target.iterdir()} | {folder.MANIFEST}),
    }
    (target / folder.MANIFEST).write_text(json.dumps(manifest, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")


def write_csv(rows: list[dict], path: Path) -> None:
    """One line a run; what a renderer does not tell is left empty."""
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(dict.fromkeys(name for row in rows for name in row)), restval="")
        writer.writeheader()
        writer.writerows(rows)


def image(path: Path, title: str) -> str:
    data = base64.b64encode(path.read_bytes()).decode("ascii")
    return f'<img src="data:image/png;base64,{data}" alt="{escape(title)}" title="{escape(title)}">'


def html(study: Study, target: Path, figures: list[tuple[Picture, list[Path]]]) -> str:
    """The page."""
    reference = study.reference
    facts = "".join(f"<dt>{escape(name)}</dt><dd>{escape(text)}</dd>" for name, text in study.facts)
    notes = "".join(f"<li>{escape(text)}</li>" for text in study.notes)
    images = "".join(
        f"<figure><figcaption>{escape(picture.row['family'])}, {escape(picture.row['setting'])}:"
        f" {picture.row['seconds']:.3g} s</figcaption>"
        + "".join(image(path, f"{path.stem} {picture.row['family']}") for path in files)
        + "</figure>"
        for picture, files in figures
    )
    antialiased = ANTIALIASED if study.own["pixel_samples"] > 1 else ""
    return f"""{HEAD}
<h1>Speed against error</h1>
<ul class="verdicts">{"".join(f"<li>{text}</li>" for text in verdicts(study))}</ul>
{image(target / PLOT, "seconds against error")}
<p>Error of a pixel: its difference from the reference, times 2<sup>exposure</sup>, largest of red, green and blue, 1 =
white before the view transform; above white, relative to the pixel's value. Penumbra's seconds: export, building the
ray tracing structure and rendering. Those of Cycles: a whole final render. Short runs: the fastest of
three.{antialiased}</p>
<h2>Figures</h2>
{table(study.rows)}
<p>Within tolerance: the share of pixels whose error is at most the run's own tolerance, or yours,
{study.own["error_tolerance"]:g}, where the rule has none. All figures: <code>{TABLE}</code>.</p>
<h2>Where the error is, and where the points went</h2>
<div class="images">{images}</div>
<h2>What was rendered</h2>
<div class="what">{image(target / REFERENCE, "reference")}<dl>{facts}
<dt>Reference</dt><dd>{escape(reference.description)}. Its own error, from the difference of the two: 99 % of the pixels
within {reference.error_p99:.2g}, RMSE {reference.error_rmse:.2g}.</dd></dl></div>
{f"<h2>Notes</h2><ul>{notes}</ul>" if notes else ""}
</body></html>
"""
