# SPDX-License-Identifier: GPL-3.0-or-later
"""The numbers between measuring and telling: CSV files, arrays of pixels, and tables in Markdown."""

import csv
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

Row = dict[str, object]


def number(text: str):
    """A field of a CSV file as int or float where it is one."""
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            pass
    return text


class Data:
    """The folder of this run's numbers: NAME.csv for rows, NAME.npz for pictures (display units, bottom row first)."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        folder.mkdir(parents=True, exist_ok=True)

    def write(self, name: str, rows: Sequence[Row]) -> None:
        with open(self.folder / f"{name}.csv", "w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, fieldnames=list(rows[0]))
            writer.writeheader()
            for row in rows:
                writer.writerow({k: f"{v:.9g}" if isinstance(v, float) else v for k, v in row.items()})

    def read(self, name: str) -> list[Row]:
        with open(self.folder / f"{name}.csv", newline="", encoding="utf-8") as file:
            return [{key: number(text) for key, text in row.items()} for row in csv.DictReader(file)]

    def write_pictures(self, name: str, **pictures: np.ndarray) -> None:
        np.savez_compressed(
            self.folder / f"{name}.npz", **{key: np.asarray(p, np.float32) for key, p in pictures.items()}
        )

    def read_pictures(self, name: str) -> dict[str, np.ndarray]:
        with np.load(self.folder / f"{name}.npz") as file:
            return {key: file[key] for key in file.files}


def where(rows: Iterable[Row], **wanted) -> list[Row]:
    """The rows with these values."""
    return [row for row in rows if all(row[key] == value for key, value in wanted.items())]


def one(rows: Iterable[Row], **wanted) -> Row:
    """The only row with these values; LookupError if there is none or more than one."""
    found = where(rows, **wanted)
    if len(found) != 1:
        raise LookupError(f"{len(found)} rows with {wanted}")
    return found[0]


def markdown(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table: the first column to the left, the others to the right."""
    lines = ["| " + " | ".join(head) + " |", "|---" + "|---:" * (len(head) - 1) + "|"]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows]) + "\n"
