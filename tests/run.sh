#!/bin/sh
# Every test and check there is.
#
#   sh tests/run.sh            installs what is missing and runs all steps
#   sh tests/run.sh STEP...    runs only the steps named (first column below)
#
# One line a step; the log of each is build/logs/STEP.log.

steps='
gcc-double    preset gcc-double
gcc-float     preset gcc-float
clang-double  preset clang-double
clang-float   preset clang-float
asan          preset asan
asan-float    preset asan-float
shared        preset shared
cortex-m0     preset cortex-m0
cortex-m4f    preset cortex-m4f
cortex-m7     preset cortex-m7
m7-double     preset cortex-m7-double
cortex-m33    preset cortex-m33
rv32imac      preset rv32imac
rv32imafc     preset rv32imafc
mips          preset mips
mips-double   preset mips-double
regression    preset_build gcc-double && regressions
consumers     sh tests/consumers/run.sh build/consumers
single-file   sh tests/ways/single_file.sh build/single_file
ways          sh tests/ways/run.sh build/ways
hooks         sh tests/ways/hooks.sh build/hooks
cli           $PYTHON tests/cli/test_cli.py
cli-float     RIGCAL_BIN=build/gcc-float/rigcal $PYTHON tests/cli/test_cli.py
cli-asan      RIGCAL_BIN=build/asan/rigcal $PYTHON tests/cli/test_cli.py
ffi           sh examples/ffi/run.sh
firmware      sh examples/firmware/run.sh build/firmware
paper         $PYTHON tests/checks/check_paper.py
readme        $PYTHON tests/checks/check_readme.py
vectors       $PYTHON tests/vectors/make_vectors.py --check
layers        $PYTHON tests/checks/check_layers.py
manifests     $PYTHON tests/checks/check_manifests.py
symbols       $PYTHON tests/checks/check_symbols.py
callgraph     $PYTHON tests/checks/check_callgraph.py build/callgraph
header        sh tests/checks/check_header.sh
cross         sh tests/checks/check_cross.sh
figures       $PYTHON port/qemu/figures.py
cppcheck      sh tests/checks/check_cppcheck.sh
shell         sh tests/checks/check_shell.sh
words         sh tests/checks/check_words.sh
'

set -u
cd "$(dirname "$0")/.." || exit 1
. tests/support/packages.sh

want gcc gcc --version
want libc6-dev test -e /usr/include/stdio.h
want g++ g++ --version
want clang clang --version
want cmake cmake --version
want ninja-build ninja --version
want xz-utils xz --version
want pkgconf pkg-config --version
want cppcheck cppcheck --version
want rustc rustc --version
want gcc-arm-none-eabi arm-none-eabi-gcc --version
want qemu-system-arm qemu-system-arm --version
want picolibc-arm-none-eabi \
    arm-none-eabi-gcc --specs=picolibc.specs -E -x c /dev/null
want gcc-riscv64-unknown-elf riscv64-unknown-elf-gcc --version
want picolibc-riscv64-unknown-elf \
    riscv64-unknown-elf-gcc --specs=picolibc.specs -E -x c /dev/null
want qemu-system-misc qemu-system-riscv32 --version
want gcc-mips-linux-gnu mips-linux-gnu-gcc --version
want libc6-dev-mips-cross test -e /usr/mips-linux-gnu/include/stdio.h
want qemu-user qemu-mips --version
want arduino-builder arduino-builder -version
want python3-venv /usr/bin/python3 -c "import ensurepip"
find_python numpy scipy >/dev/null ||
    missing="$missing python3 python3-numpy python3-scipy"
install_missing || exit 1

# A bare chroot has no /proc.
if [ ! -e /proc/self/maps ]; then
    echo "mounting /proc, which the sanitizers and rustc need"
    mount -t proc proc /proc ||
        echo "It cannot be mounted: steps that need it will fail." >&2
fi

# Unity comes from Debian's sources; where it cannot, CMake clones upstream's.
sh tests/support/get_unity.sh \
    "${XDG_CACHE_HOME:-${HOME:-/nowhere}/.cache}/rigcal/unity-2.5.1" 2>/dev/null
if [ $? -eq 1 ]; then
    want git git --version
    want ca-certificates test -e /etc/ssl/certs/ca-certificates.crt
    install_missing || exit 1
fi

PYTHON=$(find_python numpy scipy) || {
    echo "There is no Python 3 with numpy and scipy." >&2
    exit 1
}
export PYTHON
jobs=$(nproc 2>/dev/null || echo 2)

preset_build() {
    cmake --preset "$1" && cmake --build --preset "$1" -j "$jobs"
}

preset() {
    preset_build "$1" && ctest --preset "$1" -j "$jobs"
}

# Every tests/regression/*.sh, each with an empty folder of its own.
regressions() {
    bad=
    count=0
    for script in tests/regression/*.sh; do
        [ -e "$script" ] || continue
        name=$(basename "$script" .sh)
        work=build/regression/$name
        rm -rf "$work"
        mkdir -p "$work"
        echo "== $name"
        sh "$script" "$work" || bad="$bad $name"
        count=$((count + 1))
    done
    if [ -n "$bad" ]; then
        echo "regressions:$bad"
        return 1
    fi
    echo "$count scripts"
}

# What a step's log tells in one phrase: ctest's count, or its last line.
summary() {
    if count=$(sed -n 's/.* tests failed out of \([0-9]*\)$/\1 tests/p' "$1") &&
            [ -n "$count" ]; then
        echo "$count"
    else
        tail -n 1 "$1"
    fi
}

mkdir -p build/logs
passed=0
failed=
known=
while read -r name command; do
    [ -n "$name" ] || continue
    known="$known $name"
    case " $* " in
    "  " | *" $name "*) ;;
    *) continue ;;
    esac
    log=build/logs/$name.log
    begin=$(date +%s)
    if (eval "$command") >"$log" 2>&1 </dev/null; then
        passed=$((passed + 1))
        echo "ok    $name: $(summary "$log"), $(($(date +%s) - begin)) s"
    else
        failed="$failed $name"
        echo "FAIL  $name, $(($(date +%s) - begin)) s; the end of $log:"
        tail -n 30 "$log" | sed 's/^/      /'
    fi
done <<END
$steps
END

for name in "$@"; do
    case "$known " in
    *" $name "*) ;;
    *) echo "There is no step $name." >&2; failed="$failed $name" ;;
    esac
done

set -- $failed
if [ $# -eq 0 ]; then
    echo "All is well."
else
    echo "Failed: $*. The logs are in build/logs."
fi
echo "$passed passed, $# failed"
[ $# -eq 0 ]
