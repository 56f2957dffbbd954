# SPDX-License-Identifier: GPL-3.0-or-later
"""The folder of a report: whole or not there, and never over something that is not a former report."""

import json
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

MANIFEST = "report.json"
"""Its key "files" names every file of a report, itself included."""


def is_former_report(folder: Path) -> bool:
    """Whether a folder holds a report and nothing beside it."""
    try:
        files = json.loads((folder / MANIFEST).read_text(encoding="utf-8"))["files"]
    except (OSError, ValueError, KeyError, TypeError):
        return False
    return {path.name for path in folder.iterdir()} <= set(files)


def checked(target: Path) -> Path:
    """The absolute path of a folder that a report may be written to; OSError with a sentence if it may not."""
    target = Path(os.path.abspath(target))
    parent = target.parent
    if not parent.is_dir() or not os.access(parent, os.W_OK | os.X_OK):
        raise OSError(f"report: the folder {parent} does not exist or cannot be written to")
    if target.is_symlink() or (target.exists() and not target.is_dir()):
        raise OSError(f"report: {target} exists and is not a folder")
    if target.exists() and any(target.iterdir()) and not is_former_report(target):
        raise OSError(f"report: the folder {target} is neither empty nor a former report with nothing beside it")
    return target


@contextmanager
def whole_or_nothing(target: Path) -> Iterator[Path]:
    """Yields a hidden folder beside `target` that takes its place at the end, or goes away if anything fails."""
    unfinished, former = (target.with_name(f".{target.name}.{os.getpid()}.{kind}") for kind in ("tmp", "old"))
    try:
        unfinished.mkdir()
        yield unfinished
        files = sorted(path.name for path in unfinished.iterdir())
        if MANIFEST not in files:
            raise OSError(f"report: {MANIFEST} was not written")
        checked(target)  # rendering takes a while
        if target.exists():
            os.replace(target, former)
        try:
            os.replace(unfinished, target)
        except OSError:
            if former.exists():
                os.replace(former, target)
            raise
    finally:
        shutil.rmtree(unfinished, ignore_errors=True)
        if target.exists():
            shutil.rmtree(former, ignore_errors=True)
