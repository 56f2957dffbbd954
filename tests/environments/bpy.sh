#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# The tests with Blender as the module bpy of PyPI, in a virtual environment: builds the native module against the
# libraries that bpy brings, as for Blender's official builds, then tests the core, the module and the add-on.
#   bash tests/environments/bpy.sh VERSION [HEADERS]      VERSION: of bpy, such as 5.2.*; HEADERS: a folder with those
#                                                         of Embree, of that version, if not the system's
set -euo pipefail

version=$1
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
environment=${XDG_CACHE_HOME:-$HOME/.cache}/penumbra/bpy
python=$environment/bin/python
export PYTHONDONTWRITEBYTECODE=1

bash examples/install.sh --tests
if ! "$python" -c "import bpy, hypothesis, matplotlib, markdown, pybind11, pytest" 2>/dev/null; then
  rm -rf "$environment"
  python3 -m venv "$environment"
  "$python" -m pip install --quiet "bpy==$version" pybind11 pytest hypothesis matplotlib markdown
fi
libraries=$("$python" -c "import bpy, os; print(os.path.dirname(bpy.utils.resource_path('LOCAL')) + '/lib')" | tail -n 1)

echo "== build"
cmake --preset test ${2:+-DCMAKE_INCLUDE_PATH="$2"} -DPENUMBRA_BLENDER_LIBRARIES="$libraries" \
  -DPENUMBRA_PYTHON="$python" -Dpybind11_DIR="$("$python" -m pybind11 --cmakedir)"
cmake --build --preset test

echo "== the core"
ctest --preset test

echo "== the module"
"$python" -m pytest -q -p no:cacheprovider -m "not slow" tests/python tests/hard_cases tests/fuzz

echo "== the add-on, with bpy"
"$python" tests/blender/run_in_blender.py -- -q -m "not slow"
