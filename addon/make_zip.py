# SPDX-License-Identifier: GPL-3.0-or-later
"""Packs the add-on, native module included, into two zips that Blender installs: make_zip.py FOLDER.

penumbra-VERSION-legacy-PYTHON-PLATFORM.zip is for Blender up to 4.1 ("Install...") and still works in later ones;
penumbra-VERSION-extension-PYTHON-PLATFORM.zip is for Blender 4.2 and later ("Install from Disk..."). Run it with the
Python that the native module was built for.
"""

import re
import sys
import sysconfig
import zipfile
from pathlib import Path

PACKAGE = Path(__file__).resolve().parent / "penumbra"
MANIFEST = "blender_manifest.toml"
PLATFORMS = {
    "linux-x86_64": "linux-x64",
    "linux-aarch64": "linux-arm64",
    "win-amd64": "windows-x64",
    "win-arm64": "windows-arm64",
}


def blender_platform() -> str:
    """This machine's name in a manifest."""
    platform = sysconfig.get_platform()
    if platform.startswith("macosx"):
        return "macos-arm64" if platform.endswith("arm64") else "macos-x64"
    return PLATFORMS.get(platform, platform)


def write(archive: Path, files: list[tuple[Path, str]], texts: dict[str, str]) -> None:
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as target:
        for path, name in files:
            target.write(path, name)
        for name, text in texts.items():
            target.writestr(name, text)
    print(archive)


def main(folder: Path) -> None:
    native = PACKAGE / f"penumbra_native{sysconfig.get_config_var('EXT_SUFFIX')}"
    if not native.exists():
        sys.exit(f"make_zip.py: {native} is missing: build it first")
    sources = sorted(path for path in PACKAGE.rglob("*.py") if "__pycache__" not in path.parts)
    files = [(path, path.relative_to(PACKAGE).as_posix()) for path in [*sources, native]]
    manifest = (PACKAGE / MANIFEST).read_text(encoding="utf-8")
    version = re.search(r'^version = "(.*)"$', manifest, re.MULTILINE)[1]
    python, platform = f"cp{sys.version_info.major}{sys.version_info.minor}", blender_platform()
    manifest = manifest.replace("\n[permissions]", f'platforms = ["{platform}"]\n\n[permissions]')

    write(folder / f"penumbra-{version}-legacy-{python}-{platform}.zip",
          [(path, f"penumbra/{name}") for path, name in files], {})  # fmt: skip
    write(folder / f"penumbra-{version}-extension-{python}-{platform}.zip", files, {MANIFEST: manifest})


if __name__ == "__main__":
    main(Path(sys.argv[1]))
