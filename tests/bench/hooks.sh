#!/bin/sh
# What the functions of port/cmsis_dsp gain on a Cortex-M4F, and what they cost, as
# the Markdown table of port/cmsis_dsp/README.md. Run by hand; wants qemu-system-arm.
#
#   sh tests/bench/hooks.sh
#
# Error of an input: the largest difference of any number returned from that of a
# double build on this machine.
set -eu
cd "$(dirname "$0")/../.."
build=build/hooks
mkdir -p $build

# Builds a float image for the board of tests/bench/bench_hooks.c and runs it. $1 is its
# name; the rest is compiled with it.
emulate() {
    name=$1
    shift
    arm-none-eabi-gcc --specs=picolibc.specs -mcpu=cortex-m4 -mthumb \
        -mfloat-abi=hard -mfpu=fpv4-sp-d16 -std=c99 -O2 -ffp-contract=off \
        -ffunction-sections -fdata-sections --crt0=semihost --oslib=semihost \
        -DPICOLIBC_DOUBLE_PRINTF_SCANF -Wl,--gc-sections \
        -Wl,--defsym=__flash=0,--defsym=__flash_size=0x400000 \
        -Wl,--defsym=__ram=0x20000000,--defsym=__ram_size=0x400000 \
        -Wl,--defsym=__stack_size=0x4000 -DRIGCAL_USE_FLOAT=1 -Iinclude "$@" \
        src/*.c tests/bench/bench_hooks.c -lm -o "$build/$name.elf"
    timeout 7200 qemu-system-arm -M mps2-an386 -icount shift=10 -display none \
        -monitor none -serial none -chardev stdio,id=console \
        -semihosting-config enable=on,target=native,chardev=console \
        -kernel "$build/$name.elf" </dev/null >"$build/$name.txt"
}

gcc -std=c99 -O2 -ffp-contract=off -Iinclude src/*.c tests/bench/bench_hooks.c -lm \
    -o $build/double
$build/double >$build/double.txt
emulate libm
emulate tables '-DRIGCAL_CONFIG_FILE="rigcal_config_cmsis_dsp.h"' -Iport/cmsis_dsp \
    port/cmsis_dsp/rigcal_tables.c

arm-none-eabi-gcc --version | sed -n '1s/(.*) //p'
echo
awk '
FNR == 1 { file++ }
$1 == "of" {
    job = $2
    turn = ++turns[file " " job]
    worst = 0
    for (k = 3; k <= NF; k++) {
        if (file == 1) truth[job " " turn " " k] = $k
        d = $k - truth[job " " turn " " k]
        if (d < 0) d = -d
        if (d > worst) worst = d
    }
    # sorts the errors as they come
    for (i = turn; i > 1 && error[file " " job " " (i - 1)] > worst; i--) {
        error[file " " job " " i] = error[file " " job " " (i - 1)]
    }
    error[file " " job " " i] = worst
}
$1 == "job" {
    if (file == 1) names[++n] = $2
    count[file " " $2] = $3
}
function errors(file, job,    n) {
    n = turns[file " " job]
    return sprintf("%.1e, %.1e", error[file " " job " " int((n + 1) / 2)],
                   error[file " " job " " n])
}
END {
    print "| job | instructions: libm | tables | error, median and worst: libm | tables |"
    print "| --- | ---: | ---: | ---: | ---: |"
    for (i = 1; i <= n; i++) {
        name = names[i]
        label = name
        gsub("_,|,_", ", ", label)
        sub("_points", " points", label)
        printf "| `%s` | %d | %d | %s | %s |\n", label, count["2 " name],
               count["3 " name], errors(2, name), errors(3, name)
    }
}' $build/double.txt $build/libm.txt $build/tables.txt
