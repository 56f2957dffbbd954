#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Meant for .ci/run, once all environments pass: the README's two commands, what tests/checks.sh checks, and meanwhile, on
# the other core, the Blenders that users have. All is run whatever fails; the totals are at the end.
set -uo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
export PATH=/usr/bin:$PATH  # Debian's Blender takes the standard library of the first python3 on the PATH
# The same files are compiled for several folders.
export CMAKE_CXX_COMPILER_LAUNCHER=ccache CCACHE_BASEDIR=$PWD CCACHE_NOHASHDIR=1

passed=0 failed=()
step() {
  echo "=== $*"
  if "$@"; then
    passed=$((passed + 1))
  else
    echo "=== FAILED: $*"
    failed+=("$*")
  fi
}

environments=
trap '[[ -z $environments ]] || kill "$environments" 2>/dev/null' EXIT

bash examples/install.sh --tests --checks --environments --paper || exit
mkdir -p build/pictures
step bash examples/run.sh  # the environments render the scene that it makes
bash tests/environments/run.sh >build/environments.log 2>&1 &
environments=$!
step bash tests/checks.sh style
step bash tests/run.sh --strict
step bash tests/checks.sh gcc clang sanitize wheel
step blender -b --factory-startup --python-exit-code 1 -P tests/environments/picture.py -- build/pictures/bookworm

echo "=== waiting for tests/environments/run.sh"
wait "$environments"
status=$?
environments=
cat build/environments.log
step test "$status" -eq 0
step /usr/bin/python3 tests/environments/compare.py build/pictures bookworm trixie sid bpy

printf '%s\n' "${failed[@]/#/FAILED: }"
echo "$passed passed, ${#failed[@]} failed"
[[ ${#failed[@]} -eq 0 ]]
