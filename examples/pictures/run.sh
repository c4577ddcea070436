#!/bin/sh
# Makes the pictures of the documents, from nothing: installs a compiler, CMake, Ninja and
# Python if they are missing. Takes some seconds after the build.
#
#   sh examples/pictures/run.sh
#   sh examples/pictures/run.sh --check FOLDER    compares the pictures with those that the
#                                                 programs in FOLDER lead to
set -eu
cd "$(dirname "$0")/../.."
. tests/support/packages.sh

check=
built=build/release
if [ "${1:-}" = --check ]; then
    check=--check
    built=$2
fi
if [ -z "$check" ]; then
    want gcc cc --version
    want libc6-dev test -e /usr/include/stdio.h
    want cmake cmake --version
    want ninja-build ninja --version
    find_python >/dev/null || missing="$missing python3"
    install_missing
    mkdir -p build/logs
    log=build/logs/pictures.log
    drop_moved_build "$built"
    if ! { cmake --preset release && cmake --build --preset release; } \
            >"$log" 2>&1; then
        tail -n 30 "$log" >&2
        echo "The build failed; all of its output is in $log." >&2
        exit 1
    fi
fi
PYTHON=$(find_python) || {
    echo "There is no Python 3." >&2
    exit 1
}

out=build/pictures
rm -rf "$out"
mkdir -p "$out/matching"
calibrate() { # calibrate CAMERAS OBSERVATIONS FOLDER [OPTION...]
    cameras=$1 observations=$2 folder=$3
    shift 3
    "$built/rigcal" calibrate --cameras "$cameras" --observations "$observations" \
        --out "$folder" "$@" >"$folder.txt"
}
data=examples/data/opencv_stereo
calibrate "$data/cameras.csv" "$data/observations.csv" "$out/stereo"
"$built/rigcal_matching" "$data" "$out/matching" >/dev/null 2>&1
"$built/rigcal_pictures" "$out"
calibrate "$out/cameras.csv" "$out/boards.csv" "$out/watched" --sigma 0.3
# Exit status 1 is the alarm.
"$built/rigcal" monitor --rig "$out/watched/rig.csv" --matches "$out/matches.csv" \
    --common 0 --arl0 100000 >"$out/frames.csv" 2>"$out/monitor.txt" || [ $? -eq 1 ]
# shellcheck disable=SC2086 -- nothing, or one word
PYTHONDONTWRITEBYTECODE=1 "$PYTHON" examples/pictures/draw.py $check "$out" examples/pictures
