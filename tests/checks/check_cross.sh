#!/bin/sh
# Cross-builds every source for a Cortex-M4F, float, and refuses whatever wants
# double arithmetic or anything else that a bare target does not have.
set -eu
cd "$(dirname "$0")/../.."

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# The headers of picolibc, or those of newlib if the compiler finds them.
specs=
if arm-none-eabi-gcc --specs=picolibc.specs -E -x c /dev/null >/dev/null 2>&1
then
    specs=--specs=picolibc.specs
fi

for source in src/*.c; do
    arm-none-eabi-gcc $specs -mcpu=cortex-m4 -mthumb -mfloat-abi=hard \
        -mfpu=fpv4-sp-d16 -std=c99 -Os -ffp-contract=off -Wall -Wextra \
        -Wpedantic -Wconversion -Wdouble-promotion -Wshadow -Werror \
        -DRIGCAL_USE_FLOAT=1 -DRIGCAL_BUILD -Iinclude \
        -c "$source" -o "$work/$(basename "$source" .c).o"
done

# All that a float build may call: libm's float functions, memcpy and memset (under their
# Arm names too) and division of integers.
allowed='(rigcal_|rc_).*|(sqrt|sin|cos|atan2|exp|fabs)f|memcpy|memset'
allowed="$allowed|__aeabi_(mem(cpy|set|clr)[48]?|u?l?div(mod)?|u?idiv(mod)?|lmul|ll[sa][lr]r?|[ui]l2f|f2u?lz)"

status=0
for object in "$work"/*.o; do
    for symbol in $(arm-none-eabi-nm -u "$object" | awk '{print $2}' |
                    grep -Evx "$allowed"); do
        case $symbol in
        __aeabi_*d* | __aeabi_*2d | __*df* | sqrt | sin | cos | atan2 | exp | \
        fabs)
            what="double arithmetic" ;;
        *)  what="what a bare target may not have" ;;
        esac
        echo "src/$(basename "$object" .o).c wants $symbol: $what"
        status=1
    done
done
[ $status -eq 0 ] || exit 1

text=$(arm-none-eabi-size -t "$work"/*.o | awk 'END {print $1}')
echo "$text bytes of code for a Cortex-M4F, no double arithmetic"
