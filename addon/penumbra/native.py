# SPDX-License-Identifier: GPL-3.0-or-later
"""The native renderer, or the one sentence that says why it cannot be used.

`module` is penumbra_native or None; `reason` is "" or the sentence. Importing this never fails, so that the add-on can
always be enabled; rendering then reports the sentence.
"""

import re
import sys
from pathlib import Path
from types import ModuleType

NAME = "penumbra_native"


def _why_not(error: Exception) -> str:
    """One sentence for an import that failed."""
    folder = Path(__file__).parent
    files = sorted(path.name for pattern in (f"{NAME}*.so", f"{NAME}*.pyd") for path in folder.glob(pattern))
    python = f"{sys.version_info.major}.{sys.version_info.minor}"
    if not files:
        return f"The native module {NAME} is missing from {folder}: build it with `cmake --build --preset release`."
    if "cannot import name" in str(error):
        return f"The native module {', '.join(files)} was built for another Python; this Blender runs Python {python}."
    if library := re.search(r"(\S+): cannot open shared object file", str(error)):
        return f"The native module {files[0]} needs {library[1]}, which neither this Blender nor the system has."
    if "CPU ISA level" in str(error):
        return f"The native module {files[0]} needs a CPU with SSE 4.2 (x86-64-v2), which this one is not."
    return f"The native module {files[0]} cannot be loaded: {' '.join(str(error).split())}"


def _load() -> tuple[ModuleType | None, str]:
    try:
        from . import penumbra_native
    except Exception as error:  # whatever a foreign or broken binary raises
        return None, _why_not(error)
    return penumbra_native, ""


module, reason = _load()


def require() -> ModuleType:
    """The native module; RuntimeError with the reason if it could not be loaded."""
    if module is None:
        raise RuntimeError(reason)
    return module
