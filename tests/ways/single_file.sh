#!/bin/sh
# The library as one header and one source: made, built by gcc and clang as
# strictly as its parts, included from C++, and put through the tests of every layer. The
# statistics (label bench) are of the same mathematics, which gcc-double counts.
#
#   sh tests/ways/single_file.sh [FOLDER]     builds in FOLDER, build/single_file
set -eu
cd "$(dirname "$0")/../.."

mkdir -p "${1:-build/single_file}"
out=$(cd "${1:-build/single_file}" && pwd)
rm -rf "${out:?}"/*
one=$out/rigcal
${PYTHON:-python3} port/single_file/amalgamate.py "$one"

# The tests include the public headers by their names. Here each name is that one header.
mkdir "$out/names"
for header in include/*.h; do
    echo '#include <rigcal.h>' >"$out/names/$(basename "$header")"
done
rm "$out/names/rigcal.h"

strict="-Wall -Wextra -pedantic -Wpedantic -Wconversion -Wdouble-promotion -Wshadow -Werror"
for real in "" -DRIGCAL_USE_FLOAT=1; do
    for cc in gcc clang; do
        for level in -O0 -O2; do
            $cc -std=c99 $level $strict $real -c "$one/rigcal.c" -o "$out/rigcal.o"
        done
    done
    for cxx in g++ clang++; do
        $cxx -std=c++11 $strict -Wold-style-cast $real -I"$one" \
            tests/consumers/main.cpp "$out/rigcal.o" -lm -o "$out/consumer_cxx"
        "$out/consumer_cxx"
    done
done

# Its global names are those of its parts, no fewer and no more.
names() {
    nm -P -g --defined-only "$@" | awk 'NF > 2 {print $1}' | sort
}
mkdir "$out/parts"
for source in src/*.c; do
    gcc -std=c99 -DRIGCAL_BUILD -DRIGCAL_USE_FLOAT=1 -Iinclude -c "$source" \
        -o "$out/parts/$(basename "$source" .c).o"
done
names "$out"/parts/*.o >"$out/parts.txt"
names "$out/rigcal.o" | diff "$out/parts.txt" - ||
    { echo "single_file: these names differ from those of src/"; exit 1; }

for build in gcc-double clang-float; do
    cmake -G Ninja -S . -B "$out/$build" -DRIGCAL_SINGLE_FILE="$one" \
        -DCMAKE_C_COMPILER="${build%-*}" -DRIGCAL_REAL="${build#*-}" \
        -DCMAKE_BUILD_TYPE=RelWithDebInfo -DRIGCAL_WERROR=ON \
        -DCMAKE_C_FLAGS="-I$out/names" -DRIGCAL_BUILD_TESTS=ON -DRIGCAL_BUILD_BENCHES=OFF \
        -DRIGCAL_BUILD_EXAMPLES=OFF
    cmake --build "$out/$build"
    ctest --test-dir "$out/$build" --output-on-failure -L unit >"$out/$build.log" ||
        { cat "$out/$build.log"; exit 1; }
done
echo "$(wc -l <"$out/parts.txt") global names, every unit test twice, on one source"
