#!/bin/sh
# The library as one header and one source: made, built by gcc and clang as
# strictly as its parts, included from C++, and put through the tests of every layer, which
# are those of build/gcc-float.
#
#   sh tests/ways/single_file.sh [FOLDER]     builds in FOLDER, build/single_file
set -eu
cd "$(dirname "$0")/../.."

mkdir -p "${1:-build/single_file}"
out=$(cd "${1:-build/single_file}" && pwd)
rm -rf "${out:?}"/*
one=$out/rigcal
${PYTHON:-python3} port/single_file/amalgamate.py "$one"

strict="-Wall -Wextra -pedantic -Wpedantic -Wconversion -Wdouble-promotion -Wshadow -Werror"

# The single header must declare what the separate headers declare, no less and no more.
declared() {
    "$@" -E -P -std=c99 -x c - | tr -s ' \n' ' ' | tr ';' '\n' | sort
}
for header in include/*.h; do
    echo "#include \"$(basename "$header")\""
done | declared gcc -Iinclude >"$out/parts.txt"
echo '#include "rigcal.h"' | declared gcc -I"$one" >"$out/one.txt"
[ "$(wc -l <"$out/parts.txt")" -gt 100 ]
diff "$out/parts.txt" "$out/one.txt" ||
    { echo "single_file: these declarations differ from those of include/"; exit 1; }

# Each compiler with each precision, one of them without optimisation.
for how in "gcc g++ double -O2" "clang clang++ float -O2" "gcc g++ float -O0" \
    "clang clang++ double -O0"; do
    # shellcheck disable=SC2086 -- several words
    set -- $how
    real=
    [ "$3" = double ] || real=-DRIGCAL_USE_FLOAT=1
    object=$out/rigcal_$1_$3.o
    # shellcheck disable=SC2086 -- several options
    $1 -std=c99 $4 $strict -ffp-contract=off $real -c "$one/rigcal.c" -o "$object"
    # shellcheck disable=SC2086 -- several options
    $2 -std=c++11 $strict -Wold-style-cast $real -I"$one" \
        tests/consumers/main.cpp "$object" -lm -o "$out/consumer_cxx"
    "$out/consumer_cxx"
done

# The global names must be those of the parts, no fewer and no more.
names() {
    nm -P -g --defined-only "$1" | awk 'NF > 2 {print $1}' | sort
}
for how in gcc-double clang-float; do
    object=$out/rigcal_$(echo $how | tr - _).o
    build=build/gcc-${how#*-}
    names "$build/librigcal.a" >"$out/names.txt"
    names "$object" | diff "$out/names.txt" - ||
        { echo "single_file: these names differ from those of src/"; exit 1; }
done
sh tests/ways/relink.sh build/gcc-float "$out/clang-float" clang "$out/rigcal_clang_float.o"
echo "$(wc -l <"$out/names.txt") global names, and every unit test, on one source"
