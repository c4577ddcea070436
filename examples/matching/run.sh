#!/bin/sh
# Looks for every corner of the real stereo pair by its band, and draws some bands: prints
# the table of README.md and makes bands.png. Installs a compiler, CMake, Ninja, NumPy and
# matplotlib if they are missing.
set -eu
cd "$(dirname "$0")/../.."
. tests/support/packages.sh

want gcc cc --version
want libc6-dev test -e /usr/include/stdio.h
want cmake cmake --version
want ninja-build ninja --version
find_python numpy matplotlib >/dev/null ||
    missing="$missing python3 python3-numpy python3-matplotlib"
install_missing
PYTHON=$(find_python numpy matplotlib) || {
    echo "There is no Python 3 with numpy and matplotlib." >&2
    exit 1
}

mkdir -p build/logs build/matching
log=build/logs/matching.log
drop_moved_build build/release
if ! { cmake --preset release && cmake --build --preset release; } \
        >"$log" 2>&1; then
    tail -n 30 "$log" >&2
    echo "The build failed; all of its output is in $log." >&2
    exit 1
fi
build/release/rigcal_matching examples/data/opencv_stereo build/matching
"$PYTHON" examples/matching/draw.py build/matching examples/matching/bands.png
