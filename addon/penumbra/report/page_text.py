# SPDX-License-Identifier: GPL-3.0-or-later
"""The words and the table of the page."""

import math
from html import escape

from .measure import seconds_for_error
from .study import Study

HEAD = """<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>Penumbra: speed against error</title>
<meta name="viewport" content="width=device-width, initial-scale=1">
<style>
body { font: 15px/1.45 system-ui, sans-serif; color: #222; background: #fff; max-width: 1180px; margin: 2em auto;
  padding: 0 1em; }
h1 { font-size: 1.7em; } h2 { font-size: 1.2em; margin-top: 2em; }
img { max-width: 100%; height: auto; display: block; }
table { border-collapse: collapse; font-size: 13px; font-variant-numeric: tabular-nums; }
.wide { overflow-x: auto; }
th, td { padding: .15em .5em; text-align: right; white-space: nowrap; }
th { border-bottom: 1px solid #222; vertical-align: bottom; white-space: normal; }
th:first-child, td:first-child, th:nth-child(2), td:nth-child(2) { text-align: left; }
tr.first td { border-top: 1px solid #ccc; } tr.own td { background: #fff3c9; }
td.broken { color: #b2182b; } td.kept { color: #08615a; }
.images { display: grid; grid-template-columns: repeat(auto-fill, minmax(460px, 1fr)); gap: 1.5em; }
figure { margin: 0; } figcaption { font-weight: 600; margin-bottom: .3em; }
.what { display: flex; flex-wrap: wrap; gap: 1.5em; align-items: flex-start; } .what img { width: 320px; }
dl { flex: 1 1 420px; display: grid; grid-template-columns: 9em 1fr; gap: .3em 1em; margin: 0; }
dt { font-weight: 600; } dd { margin: 0; }
</style></head><body>"""

COLUMNS = (
    ("settings", "setting"), ("RMSE", "rmse"), ("mean absolute", "mean_absolute"), ("95 % below", "p95"),
    ("99 % below", "p99"), ("largest", "max"), ("tolerance", "tolerance"), ("within it", "share_within_tolerance"),
    ("rays", "rays"), ("points without ray", "points_without_ray"), ("pixels at limit", "pixels_at_sample_limit"),
    ("seconds", "seconds"), ("CPU seconds", "cpu_seconds"),
)  # fmt: skip
PROMISED_SHARE = 0.99
COMPARED = {
    "FIXED, OWEN_SOBOL": "fixed Owen-scrambled Sobol' points",
    "FIXED, PRS": "fixed pseudo-random points",
    "PAPER, OWEN_SOBOL": "the paper's rule",
    "Cycles": "Cycles",
}
"""The families that BOUNDED is compared with in words."""


def share(value: float) -> str:
    """A share of pixels in percent, rounded down: 100 % means all of them."""
    return f"{math.floor(value * 1e4) / 100:.2f} %"


def cell(row: dict, column: str) -> str:
    """One cell of the table."""
    value, kind = row.get(column), ""
    if value is None:
        text = "-"
    elif column == "share_within_tolerance":
        text, kind = share(value), ' class="kept"' if value >= PROMISED_SHARE else ' class="broken"'
    elif isinstance(value, int):
        text = f"{value:,}"
    else:
        text = value if isinstance(value, str) else f"{value:.3g}"
    return f"<td{kind}>{escape(text)}</td>"


def table(rows: list[dict]) -> str:
    """All runs, a line each; the user's own settings are marked."""
    lines, family = [], None
    for row in rows:
        first = row["family"] != family
        family = row["family"]
        classes = " ".join(word for word, true in (("first", first), ("own", row["own_settings"])) if true)
        cells = "".join(cell(row, column) for _, column in COLUMNS)
        lines.append(f'<tr class="{classes}"><td>{escape(family) if first else ""}</td>{cells}</tr>')
    head = "".join(f"<th>{escape(title)}</th>" for title in ("", *(title for title, _ in COLUMNS)))
    return f'<div class="wide"><table><tr>{head}</tr>{"".join(lines)}</table></div>'


def comparison(rows: list[dict], name: str, p99: float, seconds: float) -> str:
    """What a family needs for the error that BOUNDED reached in so many seconds, in one sentence."""
    needed, first, last = seconds_for_error(rows, p99), rows[0], rows[-1]
    if needed is None:
        return f"With {name}, already {first['setting']}, in {first['seconds']:.3g} s, reached that."
    if needed == float("inf"):
        return (f"With {name}, not even {last['setting']} reached that: 99 % of the pixels are within"
                f" {last['p99']:.2g} after {last['seconds']:.3g} s.")  # fmt: skip
    return f"With {name} the same 99th percentile takes {needed:.3g} s, {needed / seconds:.2g} times as long."


def verdicts(study: Study) -> list[str]:
    """What the figures say about the user's tolerance, as HTML sentences."""
    families, tolerance = study.families(), study.own["error_tolerance"]
    bounded = min(families["BOUNDED, OWEN_SOBOL"], key=lambda row: abs(math.log(row["tolerance"] / tolerance)))
    seconds, p99 = bounded["seconds"], bounded["p99"]
    found = [
        f"<b>BOUNDED with a tolerance of {bounded['tolerance']:g} took {seconds:.3g} s</b>;"
        f" {share(bounded['share_within_tolerance'])} of the pixels are within it, 99 % within {p99:.2g}."
    ]
    for family in (family for family in COMPARED if family in families):
        found.append(comparison(families[family], COMPARED[family], p99, seconds))
    if "Cycles" in families:
        row = families["Cycles"][0]
        found.append(f"Cycles with {row['setting']} took {row['seconds']:.3g} s, and 99 % of its pixels are within"
                     f" {row['p99']:.2g}.")  # fmt: skip
    return found
