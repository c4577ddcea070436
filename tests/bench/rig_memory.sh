#!/bin/sh
# Bytes of RAM that the adjustment of a rig takes, beside the views that the caller has: a
# Markdown table of BENCHMARKS.md. A step of CI; wants arm-none-eabi-gcc.
#
#   sh tests/bench/rig_memory.sh
#
# The sizes are those that the compiler for the Cortex-M4F gives (pointers of 4 bytes): they
# are the sizes of arrays in an object file, and nothing is run. One camera is held. Exit
# status 1 where a float build takes more than its limit.
set -eu
cd "$(dirname "$0")/../.."
build=build/rig_memory
placements=20
mkdir -p "$build"

# The sizes of one precision: lines "WHAT CAMERAS BYTES". Further arguments are options of
# the compiler.
sizes() {
    cat >"$build/sizes.c" <<END
#include "rigcal.h"
#define SIZES(C) \\
    char work_##C[RIGCAL_RIG_WORK((C)-1, C, $placements) * sizeof(rigcal_real)]; \\
    char poses_##C[((C) + $placements) * sizeof(rigcal_transform)]; \\
    char groups_##C[(C) * sizeof(int32_t)]; \\
    char solver_##C[sizeof(rigcal_rig_solver) + sizeof(rigcal_rig)];
SIZES(2)
SIZES(4)
SIZES(8)
END
    arm-none-eabi-gcc --specs=picolibc.specs -mcpu=cortex-m4 -mthumb -mfloat-abi=hard \
        -mfpu=fpv4-sp-d16 -std=c99 -fno-common -Iinclude "$@" -c "$build/sizes.c" \
        -o "$build/sizes.o"
    arm-none-eabi-nm -S -t d "$build/sizes.o" |
        sed -n 's/^[0-9]* 0*\([0-9]*\) [A-Za-z] \([a-z]*\)_\([0-9]*\)$/\2 \3 \1/p'
}

# The rows of a table. $2 has the limits, "CAMERAS:BYTES", or is empty.
rows() {
    awk -v build="$1" -v placements="$placements" -v limits="$2" '
    {
        bytes[$1 " " $2] = $3
        sum[$2] += $3
        count++
    }
    END {
        if (count != 12) {
            print "rig_memory.sh: the sizes cannot be read" >"/dev/stderr"
            exit 1
        }
        split(limits, list, " ")
        for (i in list) {
            split(list[i], pair, ":")
            limit[pair[1]] = pair[2]
        }
        for (c = 2; c <= 8; c *= 2) {
            is_limited = c in limit
            printf "| %s | %d x %d | %d | %d | %d | %d | %d | %s |\n", build, c, placements,
                bytes["work " c], bytes["poses " c], bytes["groups " c],
                bytes["solver " c], sum[c], limit[c]
            if (is_limited && sum[c] > limit[c]) {
                printf "rig_memory.sh: %d cameras take %d bytes, more than %d\n", c, sum[c],
                    limit[c] >"/dev/stderr"
                bad = 1
            }
        }
        exit bad
    }'
}

echo "| | cameras x placements | work | poses | groups | rig and solver | together | limit |"
echo "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |"
sizes -DRIGCAL_USE_FLOAT=1 >"$build/float.txt"
rows float "2:4608 4:8192 8:14336" <"$build/float.txt"
sizes >"$build/double.txt"
rows double "" <"$build/double.txt"

echo "rig_memory.sh: float is within its limits" >&2
