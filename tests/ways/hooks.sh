#!/bin/sh
# The functions of port/cmsis_dsp: their table, how far they are off, every test of
# the float build (build/gcc-float) with them in place of libm's in a library built with -O3,
# and that a Cortex-M4F calls no other.
#
#   sh tests/ways/hooks.sh [FOLDER]     builds in FOLDER, build/hooks
set -eu
cd "$(dirname "$0")/../.."

mkdir -p "${1:-build/hooks}"
out=$(cd "${1:-build/hooks}" && pwd)
rm -rf "${out:?}"/*
port=port/cmsis_dsp

"${PYTHON:-python3}" $port/make_table.py | grep . >"$out/table.txt"
lines=$(grep -cxFf "$out/table.txt" $port/rigcal_tables.c)
if [ "$lines" -ne "$(wc -l <"$out/table.txt")" ]; then
    echo "hooks: rigcal_tables.c is not what make_table.py prints"
    exit 1
fi

strict="-std=c99 -O2 -ffp-contract=off -Wall -Wextra -Wpedantic -Wconversion -Wdouble-promotion -Wshadow -Werror"
for cc in gcc clang; do
    # An angle that is no number must not be converted to an integer either. A trap needs no
    # runtime library, which for clang is a package of its own.
    $cc $strict -fsanitize=undefined,float-cast-overflow \
        -fsanitize-undefined-trap-on-error -I$port tests/ways/hooks.c $port/rigcal_tables.c -lm -o "$out/hooks"
    "$out/hooks"
done

gcc $strict -I$port -c $port/rigcal_tables.c -o "$out/rigcal_tables.o"
cmake --preset hooks -B "$out/library"
cmake --build "$out/library"
sh tests/ways/relink.sh build/gcc-float "$out/tests" gcc "$out/library/librigcal.a" \
    "$out/rigcal_tables.o"

mkdir "$out/m4f"
for source in src/*.c $port/rigcal_tables.c; do
    arm-none-eabi-gcc --specs=picolibc.specs -mcpu=cortex-m4 -mthumb \
        -mfloat-abi=hard -mfpu=fpv4-sp-d16 $strict -O1 -Iinclude -I$port \
        '-DRIGCAL_CONFIG_FILE="rigcal_config_cmsis_dsp.h"' \
        -c "$source" -o "$out/m4f/$(basename "$source" .c).o"
done
wanted=$(arm-none-eabi-nm -Au "$out"/m4f/rigcal_*.o | sed 's|.*/||' |
    grep -E ' (sqrtf|sinf|cosf)$' | grep -v '^rigcal_tables.o:' || true)
if [ -n "$wanted" ]; then
    echo "hooks: still asked of libm:"
    echo "$wanted"
    exit 1
fi
echo "sine, cosine and root of port/cmsis_dsp, every float test with them and -O3"
