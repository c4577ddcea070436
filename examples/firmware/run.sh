#!/bin/sh
# The firmware on its simulated board, here and on an emulated Cortex-M4F in float: the
# demonstration, then every test of tests/test_firmware.c, then a while of
# tests/long/firmware_long.c.
#
#   sh examples/firmware/run.sh [FOLDER]        FOLDER gets what is built: build/firmware
#   sh examples/firmware/run.sh FOLDER long     for long, and writes tests/long/firmware.md
#
# Wants gcc, arm-none-eabi-gcc with picolibc, qemu-system-arm, and Unity, which
# tests/support/get_unity.sh finds or fetches.
set -eu
cd "$(dirname "$0")/../.."
out=${1:-build/firmware}
mkdir -p "$out"
host_ticks=200000
m4f_ticks=5000
if [ "${2:-}" = long ]; then
    host_ticks=10000000
    m4f_ticks=100000
fi

unity="${XDG_CACHE_HOME:-${HOME:-/nowhere}/.cache}/rigcal/unity-2.5.1"
sh tests/support/get_unity.sh "$unity" 2>/dev/null || {
    unity=$out/unity
    sh tests/support/get_unity.sh "$unity"
}

strict="-std=c99 -O2 -ffp-contract=off -Wall -Wextra -Wpedantic -Wconversion
    -Wdouble-promotion -Wshadow -Werror -Iinclude -Isrc -Iexamples/firmware"
test_flags="-Itests/support -Itests/vectors -isystem $unity -DUNITY_INCLUDE_DOUBLE"
m4f="-mcpu=cortex-m4 -mthumb -mfloat-abi=hard -mfpu=fpv4-sp-d16
    --specs=picolibc.specs -ffunction-sections -fdata-sections
    -DPICOLIBC_DOUBLE_PRINTF_SCANF -DRIGCAL_USE_FLOAT=1 -DSIM_TIMER"
m4f_link="--crt0=semihost --oslib=semihost -Wl,--gc-sections
    -Wl,--defsym=__flash=0 -Wl,--defsym=__flash_size=0x400000
    -Wl,--defsym=__ram=0x20000000 -Wl,--defsym=__ram_size=0x400000
    -Wl,--defsym=__stack_size=16384"

# build NAME COMPILER... makes NAME_demo and NAME_test.
build() {
    name=$1
    shift
    objects=$out/$name
    tests=$out/$name/tests
    mkdir -p "$tests"
    for source in src/*.c examples/firmware/line.c examples/firmware/watch.c \
        examples/firmware/sim_port.c; do
        "$@" $strict -DRIGCAL_BUILD -c "$source" \
            -o "$objects/$(basename "$source" .c).o"
    done
    "$@" $strict -Drigcal_pose_step=sim_pose_step -Drigcal_rig_step=sim_rig_step -c \
        examples/firmware/firmware.c -o "$objects/firmware.o"
    "$@" -O2 -DUNITY_INCLUDE_DOUBLE -c "$unity/unity.c" -o "$tests/unity.o"
    "$@" $strict $test_flags -c tests/support/test_support.c \
        -o "$tests/test_support.o"
    "$@" $strict $test_flags $link tests/test_firmware.c "$tests"/*.o \
        "$objects"/*.o -lm -o "$out/${name}_test"
    "$@" $strict $link -DLONG_TICKS="$m4f_ticks" tests/long/firmware_long.c \
        "$objects"/*.o -lm -o "$out/${name}_long"
    "$@" $strict $link examples/firmware/sim_demo.c "$objects"/*.o -lm \
        -o "$out/${name}_demo"
}

# -icount makes QEMU's clock one of instructions, for the timer that sim_port.c reads.
emulate() {
    timeout 7200 qemu-system-arm -M mps2-an386 -icount shift=10 -display none \
        -monitor none -serial none -chardev stdio,id=sh -semihosting-config \
        enable=on,target=native,chardev=sh,arg=firmware -kernel "$1" </dev/null
}

# Records the table of the long runs, with three more seeds on this machine.
record() {
    for seed in 2 3 4; do
        "$out/host_long" "$host_ticks" "$seed" >>"$out/host_long.txt" || true
    done
    {
        cat <<END
# The firmware example for long

\`nice sh examples/firmware/run.sh build/firmware long\` wrote this file. The rows of "double" ran here
($(uname -m), $(gcc --version | head -1), -O2), those of "float" on an emulated Cortex-M4F
($(arm-none-eabi-gcc --version | head -1), $(qemu-system-arm --version | head -1)).
Commit $(git describe --always --dirty --exclude '*' 2>/dev/null || echo unknown).

- wrong names: of all that were named after a bump; then how many the stated confidences allow on average
- false alarms: of a rig that stood still; then how many the stated rate (one in 864 000 frames) allows on average
- second alarms: a camera was bumped, the power went before that was stored, and the rig that was loaded gave an alarm. It was
  mended, and within 400 frames there was another alarm. Of all alarms of such starts
- in doubt: starts from a rig that was stored after a bump and before its alarm. It may be right or wrong, and the board is held up again
- watchdog: units spent at most between two feeds

| real | seed | ticks | frames | resets | power cuts | bits flipped | saved | failed | bumps | wrong names | false alarms | second alarms | in doubt | watchdog | all held |
| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |
END
        grep '^|' "$out/host_long.txt" "$out/m4f_long.txt" | sed 's/^[^|]*//'
    } >tests/long/firmware.md
}

link=
build host gcc
link=$m4f_link
# shellcheck disable=SC2086 -- a list of options
build m4f arm-none-eabi-gcc $m4f

echo "== here, in double"
"$out/host_demo"
"$out/host_test" >"$out/host_test.txt" || { cat "$out/host_test.txt"; exit 1; }
grep Tests "$out/host_test.txt"

echo "== on an emulated Cortex-M4F, in float"
emulate "$out/m4f_demo"
emulate "$out/m4f_test" >"$out/m4f_test.txt" || { cat "$out/m4f_test.txt"; exit 1; }
grep Tests "$out/m4f_test.txt"

echo "== for long: tests/long/firmware_long.c says what the columns are"
"$out/host_long" "$host_ticks" >"$out/host_long.txt" || { cat "$out/host_long.txt"; exit 1; }
emulate "$out/m4f_long" >"$out/m4f_long.txt" || { cat "$out/m4f_long.txt"; exit 1; }
cat "$out/host_long.txt" "$out/m4f_long.txt"
if [ "${2:-}" = long ]; then
    record
fi

arm-none-eabi-size "$out/m4f/firmware.o" "$out/m4f/rigcal_store.o"
echo "firmware: demonstration and tests as they should be, on host and Cortex-M4F"
