#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# All tests, from a fresh Debian 12 machine: installs what is missing, builds, then tests the core (GoogleTest), the
# module (pytest with NumPy scenes) and the add-on (pytest inside Blender). Works from any folder and asks no question.
#   bash tests/run.sh [--quick] [--strict]      --quick: without the long statistics (the tests marked slow)
#                                               --strict: a warning of the compiler is an error
set -euo pipefail

tests="slow or not slow" strict=OFF
for argument in "$@"; do
  case "$argument" in
    --quick) tests="not slow" ;;
    --strict) strict=ON ;;
    *)
      echo "run.sh: unknown argument '$argument' (there are --quick and --strict)" >&2
      exit 2
      ;;
  esac
done
repository=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$repository"
export PATH=/usr/bin:$PATH  # Debian's Blender takes the standard library of the first python3 on the PATH
export PYTHONDONTWRITEBYTECODE=1

bash examples/install.sh --tests --paper

echo "== build"
cmake --preset test -DCMAKE_COMPILE_WARNING_AS_ERROR=$strict
cmake --build --preset test

echo "== the core"
ctest --preset test

echo "== the module"
/usr/bin/python3 -m pytest -q -p no:cacheprovider -m "$tests" tests/python tests/hard_cases tests/fuzz

echo "== the add-on, inside Blender"
blender -b --factory-startup --python-exit-code 1 -P tests/blender/run_in_blender.py -- -q -m "$tests"

echo "All tests passed."
