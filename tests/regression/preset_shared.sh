#!/bin/sh
# The preset shared builds the shared library and nothing else.
#
#   sh tests/regression/preset_shared.sh FOLDER
set -eu
out=$(cd "$1" && pwd)
cmake --preset shared >"$out/cmake.txt" 2>&1 || { cat "$out/cmake.txt"; exit 1; }
compiled=$(grep -c '"file":' build/shared/compile_commands.json)
sources=$(find src -name '*.c' | wc -l)
if [ "$compiled" -ne "$sources" ]; then
    echo "preset_shared: compiles $compiled files, not the $sources of src/:"
    grep '"file":' build/shared/compile_commands.json | grep -v /src/ | head -n 5
    exit 1
fi
cmake --build --preset shared >"$out/build.txt"
[ -e build/shared/librigcal.so ] || { echo "preset_shared: there is no librigcal.so"; exit 1; }
echo "$compiled sources and one library"
