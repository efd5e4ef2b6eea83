#!/usr/bin/env bash
# Opens a VDB sequence in Blender, lists its grids and renders one frame of it with Cycles; exits with 1 where
# Blender cannot use the files.
#   ./tools/dev/check_blender.sh NAME.0001.vdb OUT.png [FRAME] [--surface GRID] [--up y|z]
# FRAME is the number in the file's name (default: the middle one). Shown is `density` as smoke (with `vel`,
# `temperature`, `flame` and `color` if there), else the level set `surface` (or that of --surface) as a mesh.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
source "$here/setup.sh"

install_packages blender python3-openvdb python3-numpy

# Blender aborts where OpenVDB finds a file damaged, and what it prints then can be as long as a name in a
# broken file claims to be: hence `cut`, and the parentheses, which keep bash from reporting the abort, too.
say "Blender: ${1:-}"
code=0
(blender -b --factory-startup -noaudio -t "$(build_jobs)" --python-exit-code 1 \
  -P "$here/check_blender.py" -- "$@" 2>&1 || exit $?) 2>/dev/null |
  stdbuf -oL cut -b 1-300 | sed -u '/^Fra:/d; /^Saved:/d; /^ Time:/d; /^Blender quit/d; /^$/d' || code=$?
if [ $code -ge 128 ]; then
  echo "check_blender: Blender crashed (exit code $code): the file that it read last is damaged" >&2
fi
[ $code = 0 ] || exit 1
