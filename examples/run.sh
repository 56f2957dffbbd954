#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Everything from a fresh Debian 12 machine to a picture: installs what is missing, builds, makes the example scene and
# renders it. The picture and its statistics go to examples/output/. Works from any folder and asks no question.
set -euo pipefail

# Debian's Blender takes the standard library of the first python3 on the PATH, which must be Debian's own.
export PATH="/usr/bin:$PATH"

examples=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
output="$examples/output"
mkdir -p "$output"

bash "$examples/install.sh"

cd "$examples/.."
cmake --preset release
cmake --build --preset release

blender -b --factory-startup --python-exit-code 1 -P "$examples/make_four_objects.py"
blender -b --python-exit-code 1 -P "$examples/penumbra_addon.py" "$examples/four_objects.blend" -P "$examples/render.py" -- \
  --output "$output/four_objects.exr" --view "$output/four_objects.png" --statistics "$output/four_objects.json"
