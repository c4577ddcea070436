#!/bin/sh
# The library and the command line for Windows, built by gcc-mingw-w64 without a warning.
#
#   sh tests/checks/check_windows.sh FOLDER            builds in FOLDER
#   sh tests/checks/check_windows.sh FOLDER RIGCAL     and compares: Wine runs the program,
#       RIGCAL is the same of this system; what they print and write is equal, byte for byte
set -eu
cd "$(dirname "$0")/../.."
mkdir -p "$1"
out=$(cd "$1" && pwd)

cmake -S . -B "$out" -G Ninja -DCMAKE_SYSTEM_NAME=Windows \
    -DCMAKE_C_COMPILER=x86_64-w64-mingw32-gcc -DRIGCAL_WERROR=ON >"$out/log"
cmake --build "$out" --target rigcal_cli >>"$out/log" || { cat "$out/log"; exit 1; }
echo "rigcal.exe: built"
[ $# -gt 1 ] || exit 0
export WINEDEBUG=-all
wine "$out/rigcal.exe" --version >/dev/null 2>&1 # which may first set Wine up

# Calibrates into $out/$1 with the program that follows.
calibrate() {
    into=$1
    shift
    rm -rf "${out:?}/$into"
    status=0
    "$@" calibrate --cameras "$data/cameras.csv" --observations "$data/observations.csv" \
        --out "$out/$into" --sigma 0.3 >"$out/$into.stdout" 2>"$out/$into.stderr" || status=$?
    echo "$status" >"$out/$into/status"
    for stream in stdout stderr; do
        mv "$out/$into.$stream" "$out/$into/$stream"
    done
}

for data in examples/data/*/; do
    [ -f "$data/observations.csv" ] && [ -f "$data/cameras.csv" ] || continue
    calibrate here "$2"
    calibrate windows wine "$out/rigcal.exe"
    diff -r "$out/here" "$out/windows"
    echo "$data: $(find "$out/here" -type f | wc -l) files, equal"
done
