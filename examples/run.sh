#!/bin/sh
# Calibrates the real stereo pair in examples/data, from nothing: installs a
# compiler, CMake and Ninja if they are missing, builds, and prints the result.
set -eu
cd "$(dirname "$0")/.."
. tests/support/packages.sh

want gcc cc --version
want libc6-dev test -e /usr/include/stdio.h
want cmake cmake --version
want ninja-build ninja --version
install_missing

mkdir -p build/logs
log=build/logs/example.log
drop_moved_build build/release
if ! { cmake --preset release && cmake --build --preset release; } \
        >"$log" 2>&1; then
    tail -n 30 "$log" >&2
    echo "The build failed; all of its output is in $log." >&2
    exit 1
fi

data=examples/data/opencv_stereo
out=build/stereo
mkdir -p "$out"
if ! build/release/rigcal calibrate --cameras "$data/cameras.csv" \
        --observations "$data/observations.csv" --out "$out"; then
    echo "rigcal calibrate failed, see above." >&2
    exit 1
fi
echo "The poses and transforms are in $out:" "$(cd "$out" && echo *.csv)"
