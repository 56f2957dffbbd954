#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# The tests in the Blenders that users have, each beside its own Python, Embree and OpenImageIO (see README.md here).
#   bash tests/environments/run.sh [NAME...]      bookworm trixie sid bpy arm64; all but bookworm if left out
# What cannot be reached here is skipped with a sentence, or an error where CI=true.
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
repository=$(dirname "$(dirname "$here")")
source "$here/chroot.sh"
export PATH=/usr/bin:/usr/sbin:$PATH

declare -A suites=([bookworm]=bookworm [trixie]=trixie [sid]=sid [arm64]=trixie)
declare -A packages=(  # beyond what examples/install.sh installs
  [bookworm]="ca-certificates ccache"
  # The rest is for bpy: what it is linked to and does not bring.
  [trixie]="ca-certificates ccache python3-venv libsm6 libxi6 libxkbcommon0 libxxf86vm1 libxfixes3 libxrender1 libgl1"
  # Blender 5's extension system wants the last three, and Debian's package does not say so; the headers are for bpy.
  [sid]="ca-certificates ccache libembree-dev libopenimageio-dev python3-cattr python3-requests python3-zstandard"
  [arm64]="ca-certificates ccache cmake ninja-build g++-aarch64-linux-gnu qemu-user libembree-dev:arm64 libgtest-dev:arm64"
)
declare -A command=(
  [bookworm]="bash tests/run.sh --quick"
  [trixie]="bash tests/run.sh --quick"
  [sid]="bash tests/run.sh --quick"
  [bpy]="bash tests/environments/bpy.sh 5.2.* $inside/headers"
  [arm64]="bash tests/environments/arm64.sh"
)

# prepare NAME ROOT: makes or mends the environment.
prepare() {
  if [[ $1 != bpy ]]; then
    ensure_chroot "$1" "${suites[$1]}" ${packages[$1]}
    return
  fi
  # bpy lives in trixie, for its Python; the libraries it brings are of the versions that sid has headers of.
  prepare trixie && prepare sid &&
    rm -rf "$2$inside/headers" && mkdir -p "$2$inside/headers" &&
    cp -r "$cache/sid/usr/include/"{embree4,OpenImageIO,Imath} "$2$inside/headers/"
}

pictures=$repository/build/pictures

# run NAME ROOT: its tests, and its picture of the example scene.
run() {
  local sources=$2$inside/penumbra program="blender -b --factory-startup --python-exit-code 1 -P"
  [[ $1 != bpy ]] || program=$inside/.cache/penumbra/bpy/bin/python
  copy_sources "$repository" "$sources" &&
    enter "$2" env --chdir="$inside/penumbra" CMAKE_CXX_COMPILER_LAUNCHER=ccache ${command[$1]} || return
  [[ $1 != arm64 && -e $repository/examples/four_objects.blend ]] || return 0
  cp "$repository/examples/four_objects.blend" "$sources/examples/" &&
    enter "$2" env --chdir="$inside/penumbra" $program tests/environments/picture.py -- "build/pictures/$1" &&
    mkdir -p "$pictures" && cp -r "$sources/build/pictures/$1" "$pictures/"
}

names=("$@")
[[ $# -gt 0 ]] || names=(trixie sid bpy arm64)
passed=0 failed=0 skipped=0
mkdir -p "$cache"
exec {lock}>"$cache/lock"
flock "$lock"  # one run at a time
for name in "${names[@]}"; do
  : "${command[$name]:?there is no environment of that name}"
  root=$cache/${name/bpy/trixie}
  started=$SECONDS
  reason=$(why_no_chroot)
  if [[ -z $reason ]] && ! prepare "$name" "$root"; then
    reason="the environment could not be made"
  fi
  if [[ -n $reason && ${CI:-} != true ]]; then
    echo "== $name: skipped, $reason"
    skipped=$((skipped + 1))
    continue
  fi
  if [[ -z $reason ]] && (run "$name" "$root"); then
    echo "== $name: passed in $((SECONDS - started)) s"
    passed=$((passed + 1))
  else
    echo "== $name: FAILED after $((SECONDS - started)) s${reason:+, $reason}"
    failed=$((failed + 1))
  fi
done
echo "$passed passed, $failed failed, $skipped skipped"
[[ $failed -eq 0 ]]
