#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Installs the Debian packages that Penumbra needs and that are missing; asks no question, does nothing if all are there.
#   bash examples/install.sh [--tests] [--checks] [--environments] [--paper]      those of the tests and so on, too
set -euo pipefail

packages=(
  blender                                   # the host; its Python is /usr/bin/python3
  libembree-dev libopenimageio-dev          # ray tracing, textures
  pybind11-dev python3-dev python3-numpy    # the native module
  cmake ninja-build g++                     # the build
)
for argument in "$@"; do
  case "$argument" in
    --tests) packages+=(libgtest-dev qemu-user python3-pytest python3-hypothesis python3-openimageio
                        python3-matplotlib xvfb xauth libgl1-mesa-dri
                        assimp-testmodels) ;;  # .blend files of Blender 2.48 to 2.93
    --checks) packages+=(clang libclang-rt-dev ccache python3-venv) ;;
    --environments) packages+=(debootstrap) ;;
    --paper) packages+=(python3-matplotlib python3-markdown) ;;
    *)
      echo "install.sh: unknown argument '$argument' (there are --tests, --checks, --environments and --paper)" >&2
      exit 2
      ;;
  esac
done

missing=()
for package in "${packages[@]}"; do
  status=$(dpkg-query --show --showformat='${db:Status-Status}' "$package" 2>/dev/null || true)
  [[ "$status" == installed ]] || missing+=("$package")
done
[[ ${#missing[@]} -gt 0 ]] || exit 0

if ! command -v apt-get >/dev/null; then
  echo "install.sh: these Debian packages are missing, and there is no apt-get to install them: ${missing[*]}" >&2
  exit 1
fi
as_root=()
if [[ $EUID -ne 0 ]]; then
  if ! command -v sudo >/dev/null; then
    echo "install.sh: these packages are missing; run as root: apt-get install --no-install-recommends ${missing[*]}" >&2
    exit 1
  fi
  as_root=(sudo)
fi
echo "Installing ${missing[*]}"
"${as_root[@]}" apt-get update -qq
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
  apt-get install --yes -qq --no-install-recommends "${missing[@]}" </dev/null
