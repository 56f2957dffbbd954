#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# The tests in the Blenders that users have, each beside its own Python, Embree and OpenImageIO (see README.md here).
#   bash tests/environments/run.sh [NAME...]      bookworm trixie sid bpy arm64; all but bookworm if left out
# What cannot be reached here is skipped with a sentence, or an error where CI=true. Runs of different NAMEs may go on at
# the same time; those of one NAME wait for each other.
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
repository=$(dirname "$(dirname "$here")")
source "$here/chroot.sh"
export PATH=/usr/bin:/usr/sbin:$PATH

declare -A suites=([bookworm]=bookworm [trixie]=trixie [sid]=sid [arm64]=trixie)  # bpy lives in trixie, for its Python
declare -A packages=(  # beyond what examples/install.sh installs
  [bookworm]="ccache"
  [trixie]="ccache"
  # Blender 5 wants the last four, its extension system and its compositor, and Debian's package does not say so.
  [sid]="ccache python3-cattr python3-requests python3-zstandard libegl1"
  # What bpy is linked to and does not bring, and libegl1 for its compositor.
  [bpy]="ccache python3-venv libsm6 libxi6 libxkbcommon0 libxxf86vm1 libxfixes3 libxrender1 libgl1 libegl1"
  [arm64]="ccache cmake ninja-build g++-aarch64-linux-gnu qemu-user libembree-dev:arm64 libopenimageio-dev:arm64
           libgtest-dev:arm64"
)
declare -A command=(
  [bookworm]="bash tests/run.sh --quick"
  [trixie]="bash tests/run.sh --quick"
  [sid]="bash tests/run.sh --quick"
  [bpy]="bash tests/environments/bpy.sh 5.2.* $inside/headers"
  [arm64]="bash tests/environments/arm64.sh"
)

# place NAME: the folder that NAME lives in.
place() {
  echo "$cache/${1/bpy/trixie}"
}

# alone LOCK COMMAND...: nobody else runs a command under this lock meanwhile.
alone() {
  local lock=$cache/$1.lock
  shift
  (
    flock 8
    "$@"
  ) 8>"$lock"
}

# prepare NAME: makes or mends its environment, with all packages that its tests want.
prepare() {
  local suite=${1/bpy/trixie} root
  root=$(place "$1")
  alone "$suite.making" make "$1" "$suite" "$root" || return
  [[ $1 == bpy ]] || return 0
  # The libraries that bpy brings are of the versions that sid has headers of.
  prepare sid && rm -rf "$root$inside/headers" && mkdir -p "$root$inside/headers" &&
    cp -r "$cache/sid/usr/include/"{embree4,OpenImageIO,Imath} "$root$inside/headers/"
}

make() {
  ensure_chroot "$2" "${suites[$2]}" && install_packages "$3" ${packages[$1]} || return
  [[ $1 != arm64 ]] || return 0
  cp "$repository/examples/install.sh" "$3$inside/" && enter "$3" bash "$inside/install.sh" --tests --paper >"$3.log" 2>&1 || {
    tail -n 5 "$3.log"
    return 1
  }
  rm "$3.log"
}

pictures=$repository/build/pictures

# run NAME: its tests, and its picture of the example scene.
run() {
  local root sources program="blender -b --factory-startup --python-exit-code 1 -P"
  root=$(place "$1")
  sources=$root$inside/$1
  [[ $1 != bpy ]] || program=$inside/.cache/penumbra/bpy/bin/python
  copy_sources "$repository" "$sources" &&
    enter "$root" env --chdir="$inside/$1" CMAKE_CXX_COMPILER_LAUNCHER=ccache CCACHE_BASEDIR="$inside/$1" CCACHE_NOHASHDIR=1 ${command[$1]} || return
  [[ $1 != arm64 && -e $repository/examples/four_objects.blend ]] || return 0
  cp "$repository/examples/four_objects.blend" "$sources/examples/" &&
    enter "$root" env --chdir="$inside/$1" $program tests/environments/picture.py -- "build/pictures/$1" &&
    mkdir -p "$pictures" && cp -r "$sources/build/pictures/$1" "$pictures/"
}

names=("$@")
[[ $# -gt 0 ]] || names=(trixie sid bpy arm64)
for name in "${names[@]}"; do
  : "${command[$name]:?there is no environment of that name}"
done
passed=0 failed=0 skipped=0
mkdir -p "$cache" "$repository/build/environments"
for name in "${names[@]}"; do
  started=$SECONDS
  reason=$(why_no_chroot)
  if [[ -z $reason ]] && ! prepare "$name"; then
    reason="the environment could not be made"
  fi
  if [[ -n $reason && ${CI:-} != true ]]; then
    echo "== $name: skipped, $reason"
    skipped=$((skipped + 1))
    continue
  fi
  log=$repository/build/environments/$name.log
  if [[ -z $reason ]] && alone "$name.run" run "$name" >"$log" 2>&1; then
    grep -hE "^(Blender [0-9]|bpy [0-9]|[0-9]+ passed|[0-9]+% tests passed|\[  PASSED  \])" "$log" | sort -u
    echo "== $name: passed in $((SECONDS - started)) s"
    passed=$((passed + 1))
  else
    [[ -n $reason ]] || tail -n 500 "$log"
    echo "== $name: FAILED after $((SECONDS - started)) s${reason:+, $reason}"
    failed=$((failed + 1))
  fi
done
echo "$passed passed, $failed failed, $skipped skipped"
[[ $failed -eq 0 ]]
