#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# The paper, reproduced: installs what is missing, builds, measures inside Blender, and writes report.md, report.html,
# the figures and the numbers to examples/paper/output/. Works from any folder and asks no question.
#   bash examples/paper/run.sh [--quick]      --quick: smaller pictures, under five minutes on two cores
set -euo pipefail

paper=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
if [[ $# -gt 1 || ( $# -eq 1 && "$1" != --quick ) ]]; then
  echo "run.sh: unknown argument '$*' (there is only --quick)" >&2
  exit 2
fi

bash "$paper/../install.sh" --paper

cd "$paper/../.."
cmake --preset release
cmake --build --preset release

export PYTHONDONTWRITEBYTECODE=1
blender -b --factory-startup --python-exit-code 1 -P "$paper/reproduce.py" -- "$@"
