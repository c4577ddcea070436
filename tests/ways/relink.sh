#!/bin/sh
# The unit tests of a build, linked with another library of the same precision and run.
# The code of a test is the same whatever the library: it is not compiled again.
#
#   sh tests/ways/relink.sh BUILD FOLDER COMPILER LIBRARY...
#
# BUILD is the folder of a preset that is built; the programs are written to FOLDER. Left out
# are bounds and small, which have libraries of their own, the firmware example, and sources,
# which takes long and asks what no compiler changes.
set -eu
build=$1
out=$2
compiler=$3
shift 3

mkdir -p "$out"
count=0
for objects in "$build"/tests/CMakeFiles/test_*.dir; do
    name=$(basename "$objects" .dir)
    case $name in
    test_bounds | test_small | test_firmware | test_sources) continue ;;
    esac
    # shellcheck disable=SC2046 -- one object or more
    "$compiler" $(find "$objects" -name '*.o') "$build/tests/librigcal_test_support.a" \
        "$build/tests/libunity.a" "$@" -lm -o "$out/$name"
    "$out/$name" >"$out/$name.txt" || { cat "$out/$name.txt"; echo "relink: $name fails"; exit 1; }
    rm "$out/$name"
    count=$((count + 1))
done
layers=$(find src -name 'rigcal_*.c' | wc -l)
if [ "$count" -lt "$layers" ]; then
    echo "relink: $build has $count unit tests, fewer than there are layers"
    exit 1
fi
echo "$count unit tests of $build"
