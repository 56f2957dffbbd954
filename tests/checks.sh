#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# What is checked beside the tests, from a fresh Debian 12 machine:
#   style     ruff and clang-format
#   gcc       GCC builds all, benchmarks too, without a warning
#   clang     Clang does, and the core's tests pass
#   sanitize  the core's tests with address and undefined-behaviour sanitizers
#   wheel     pip install . in a clean environment; NumPy in and out; its type stubs
#   bash tests/checks.sh [style] [gcc] [clang] [sanitize] [wheel]      all if left out
set -euo pipefail

cd "$(dirname "${BASH_SOURCE[0]}")/.."
export PATH=/usr/bin:$PATH
cache=${XDG_CACHE_HOME:-$HOME/.cache}/penumbra
bash examples/install.sh --tests --checks

style() {
  local tools=$cache/style
  if ! "$tools/bin/ruff" --version >/dev/null 2>&1 || ! "$tools/bin/clang-format" --version >/dev/null 2>&1; then
    rm -rf "$tools"
    /usr/bin/python3 -m venv "$tools"
    "$tools/bin/pip" install --quiet ruff==0.17.6 clang-format==14.0.6
  fi
  "$tools/bin/ruff" check addon examples tests
  "$tools/bin/ruff" format --check addon examples tests
  git ls-files -z '*.h' '*.cpp' | xargs -0 "$tools/bin/clang-format" --dry-run --Werror
}

gcc() {
  cmake --preset gcc
  cmake --build --preset gcc
}

clang() {
  cmake --preset clang
  cmake --build --preset clang
  ctest --preset clang
}

sanitize() {
  cmake --preset sanitize
  cmake --build --preset sanitize
  ctest --preset sanitize
}

wheel() {
  local clean
  clean=$(mktemp -d)
  trap 'rm -rf "$clean"' RETURN
  /usr/bin/python3 -m venv "$clean"
  "$clean/bin/pip" install --quiet . mypy==1.13.0
  "$clean/bin/python" -I tests/wheel/render.py
  "$clean/bin/mypy" --strict tests/wheel/render.py
  "$clean/bin/python" -m mypy.stubtest --allowlist tests/wheel/stubtest_allowed.txt penumbra_native
}

checks=("$@")
[[ $# -gt 0 ]] || checks=(style gcc clang sanitize wheel)
for check in "${checks[@]}"; do
  case "$check" in
    style | gcc | clang | sanitize | wheel) ;;
    *)
      echo "checks.sh: unknown check '$check' (there are style, gcc, clang, sanitize and wheel)" >&2
      exit 2
      ;;
  esac
  echo "== $check"
  started=$SECONDS
  $check
  echo "== $check: passed in $((SECONDS - started)) s"
done
