#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# The core's tests for 64-bit ARM: cross-built, run by qemu-user. Needs Debian's g++-aarch64-linux-gnu, qemu-user and the
# arm64 packages of the libraries (see run.sh here).
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

cmake --preset arm64
cmake --build --preset arm64
file=build/arm64/penumbra_tests
[[ $(od --skip-bytes=18 --read-bytes=2 --format=u2 --address-radix=n $file) -eq 183 ]]  # ELF: AArch64
# In one process: loading the libraries takes seconds on an emulated CPU.
qemu-aarch64 $file --gtest_brief=1
qemu-aarch64 build/arm64/fuzz_scene --runs 100
