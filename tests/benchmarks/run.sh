#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# All benchmarks, into tests/benchmarks/output/ (tables, CSV, a plot). Half an hour; not part of the tests.
set -euo pipefail

repository=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
cd "$repository"
output=tests/benchmarks/output
mkdir -p "$output"

bash examples/install.sh --tests --paper
cmake --preset release >/dev/null && cmake --build --preset release
cmake --preset benchmark >/dev/null && cmake --build --preset benchmark

echo "== shadow rays: whole render against a raw Embree loop, one thread"
build/benchmark/ray_rate 320 5 --csv | tee "$output/ray_rate.csv"

echo "== speed against error: Penumbra and Cycles, one thread, 320 x 240"
blender -b --factory-startup --python-exit-code 1 -P examples/make_four_objects.py >/dev/null
blender -b examples/four_objects.blend --python-exit-code 1 -P tests/benchmarks/against_cycles.py -- "$output" 50 |
  grep -E "Penumbra|Cycles"

echo "== export: from Blender's arrays to the native scene, and the picture back"
blender -b --factory-startup --python-exit-code 1 -P tests/benchmarks/export.py -- "$output" | grep "^export"

echo "== antialiased pictures at equal error: Penumbra and Cycles, one thread, 320 x 240"
blender -b --factory-startup --python-exit-code 1 -P tests/benchmarks/antialiased.py -- "$output" | grep -E "P99|99th"
echo "Results are in $output/"
