#!/bin/sh
# The preset shared builds the shared library and nothing else.
#
#   sh tests/regression/preset_shared.sh FOLDER
set -eu
out=$(cd "$1" && pwd)
cmake --preset shared -B "$out" >"$out/cmake.txt" 2>&1 || { cat "$out/cmake.txt"; exit 1; }
ninja -C "$out" -n -v >"$out/commands.txt"
compiled=$(grep -c ' -c ' "$out/commands.txt")
sources=$(find src -name '*.c' | wc -l)
if [ "$compiled" -ne "$sources" ]; then
    echo "preset_shared: compiles $compiled files, not the $sources of src/"
    exit 1
fi
if grep -qiE 'test_|bench_|unity|rigcal_cli' "$out/commands.txt"; then
    echo "preset_shared: builds tests or examples"
    exit 1
fi
cmake --build "$out" >"$out/build.txt"
[ -e "$out/librigcal.so" ] || { echo "preset_shared: there is no librigcal.so"; exit 1; }
echo "$compiled sources and one library"
