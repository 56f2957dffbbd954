# SPDX-License-Identifier: GPL-3.0-or-later
"""Packs the add-on, native module included, into a zip for Blender's "Install...": make_zip.py OUT.zip."""

import sys
import zipfile
from pathlib import Path

WANTED = {".py", ".so", ".pyd", ".toml"}


def main(target: str) -> None:
    package = Path(__file__).resolve().parent / "penumbra"
    files = sorted(p for p in package.rglob("*") if p.suffix in WANTED and "__pycache__" not in p.parts)
    if not any(p.name.startswith("penumbra_native") for p in files):
        sys.exit(f"no native module in {package}: build it first")
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as archive:
        for path in files:
            archive.write(path, Path("penumbra") / path.relative_to(package))
    print(f"{target}: {len(files)} files")


if __name__ == "__main__":
    main(sys.argv[1])
