#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Benchmarks, into tests/benchmarks/output/ (tables, CSV, plots). Not part of the tests.
#   ray_rate        whole renders against a raw Embree loop
#   against_cycles  speed against error on the example scene
#   export          from Blender's arrays to the native scene, and the picture back
#   animation       frames of an animation: time and memory
#   antialiased     antialiased pictures at equal error, scene by scene
#   scale           triangles, pixels, threads, memory, building
#   many            1 to 10,000 luminaires
#   peers           equal error against Cycles and Mitsuba 3 (an hour; Mitsuba comes from PyPI, into the cache)
#   peers_sid       the same against Cycles of the Blender in Debian unstable, in the chroot that
#                   tests/environments/run.sh sid has made
#   bash tests/benchmarks/run.sh [NAME ...]      all but peers if left out: about an hour
set -euo pipefail

cd "$(dirname "${BASH_SOURCE[0]}")/../.."
output=tests/benchmarks/output
mkdir -p "$output"
script=(blender -b --factory-startup --python-exit-code 1 -P)

ray_rate() { build/benchmark/ray_rate 320 5 --csv | tee "$output/ray_rate.csv"; }

against_cycles() {
  "${script[@]}" examples/make_four_objects.py >/dev/null
  blender -b examples/four_objects.blend --python-exit-code 1 -P tests/benchmarks/against_cycles.py -- "$output" 50 |
    grep -E "Penumbra|Cycles"
}

export_and_back() { "${script[@]}" tests/benchmarks/export.py -- "$output" | grep "^export"; }

animation() { "${script[@]}" tests/benchmarks/animation.py -- "$output" | grep "^animation"; }

antialiased() { "${script[@]}" tests/benchmarks/antialiased.py -- "$output" | grep -E "P99|99th"; }

scale() { build/benchmark/scale --csv | tee "$output/scale.csv"; }

many() { /usr/bin/python3 tests/benchmarks/many_luminaires.py "$output"; }

peers() {
  local mitsuba=${XDG_CACHE_HOME:-$HOME/.cache}/penumbra/mitsuba
  bash examples/install.sh --checks
  if ! "$mitsuba/bin/python" -c "import mitsuba, numpy" 2>/dev/null; then
    /usr/bin/python3 -m venv "$mitsuba"
    "$mitsuba/bin/pip" install --quiet mitsuba numpy
  fi
  "${script[@]}" tests/benchmarks/peers.py -- "$output" 100 "$mitsuba/bin/python" | grep -vE "^(Fra:|Saved:| Time:|$)"
}

peers_sid() {
  source tests/environments/chroot.sh
  local root=$cache/sid home=$inside/benchmarks
  [[ -e $root/.penumbra ]] || { echo "run.sh: no $root; tests/environments/run.sh sid makes it" >&2 && return 1; }
  copy_sources . "$root$home"
  enter "$root" env --chdir="$home" CMAKE_CXX_COMPILER_LAUNCHER=ccache CCACHE_BASEDIR="$home" CCACHE_NOHASHDIR=1 \
    bash -c 'cmake --preset release >/dev/null && cmake --build --preset release >/dev/null'
  enter "$root" env --chdir="$home" "${script[@]}" tests/benchmarks/peers.py -- output 100 - |
    grep -vE "^(Fra:|Saved:| Time:|$)"
  mkdir -p "$output/sid"
  cp "$root$home"/output/peers.{csv,md,png} "$output/sid/"
}

names=("$@")
[[ $# -gt 0 ]] || names=(ray_rate against_cycles export animation antialiased scale many)
for name in "${names[@]}"; do
  case "$name" in
    ray_rate | against_cycles | export | animation | antialiased | scale | many | peers | peers_sid) ;;
    *)
      echo "run.sh: unknown benchmark '$name' (see its head)" >&2
      exit 2
      ;;
  esac
done

bash examples/install.sh --tests --paper
cmake --preset release >/dev/null && cmake --build --preset release
cmake --preset benchmark >/dev/null && cmake --build --preset benchmark
for name in "${names[@]}"; do
  echo "== $name"
  [[ $name != export ]] || name=export_and_back
  "$name"
done
echo "Results are in $output/"
