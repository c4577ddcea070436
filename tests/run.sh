#!/bin/sh
# Every test and check there is.
#
#   sh tests/run.sh            installs what is missing and runs all steps
#   sh tests/run.sh STEP...    runs only the steps named (first column below), and
#                              installs only what these need
#
# One line a step; the log of each is build/logs/STEP.log.

# The step, what it needs (see want_need), and its command.
steps='
gcc-double    gcc,cmake,unity              preset gcc-double
gcc-float     gcc,cmake,unity              preset gcc-float
gcc-float-O3  gcc,cmake,unity              preset gcc-float-O3
clang-double  clang,cmake,unity            preset clang-double
clang-float   clang,cmake,unity            preset clang-float
asan          gcc,cmake,unity              preset asan
asan-float    gcc,cmake,unity              preset asan-float
shared        gcc,cmake,unity              preset shared-tests
cortex-m0     arm,cmake,unity              preset cortex-m0
cortex-m4f    arm,cmake,unity              preset cortex-m4f
cortex-m7     arm,cmake,unity              preset cortex-m7
m7-double     arm,cmake,unity              preset cortex-m7-double
cortex-m33    arm,cmake,unity              preset cortex-m33
rv32imac      riscv,cmake,unity            preset rv32imac
rv32imafc     riscv,cmake,unity            preset rv32imafc
mips          mips,cmake,unity             preset mips
mips-double   mips,cmake,unity             preset mips-double
regression    gcc,clang,cmake,unity,rust,numpy
              preset_build gcc-double && regressions
consumers     gcc,g++,cmake,pkgconf        sh tests/consumers/run.sh build/consumers
install       gcc,cmake,make,pkgconf,python
              $PYTHON tests/checks/check_install.py
single-file   gcc,g++,clang,cmake,unity,python
              sh tests/ways/single_file.sh build/single_file
ways          gcc,g++,cmake,arduino,venv   sh tests/ways/run.sh build/ways
hooks         gcc,clang,arm,cmake,unity,python
              sh tests/ways/hooks.sh build/hooks
cli           gcc,cmake,unity,numpy        cli gcc-double
cli-float     gcc,cmake,unity,numpy        cli gcc-float
cli-asan      gcc,cmake,unity,numpy        cli asan
scale         gcc,cmake,unity,numpy,time
              preset_build gcc-double && $PYTHON tests/bench/scale.py build/gcc-double/rigcal short
ffi           gcc,cmake,rust,numpy         preset_build shared && sh examples/ffi/run.sh
firmware      gcc,arm,unity                sh examples/firmware/run.sh build/firmware
paper         gcc,cmake,unity,python
              preset_build gcc-double && $PYTHON tests/checks/check_paper.py
readme        gcc,python                   $PYTHON tests/checks/check_readme.py
layout        python                       $PYTHON tests/checks/check_layout.py
vectors       numpy,scipy                  $PYTHON tests/vectors/make_vectors.py --check
layers        gcc,python                   $PYTHON tests/checks/check_layers.py
limits        gcc,python                   $PYTHON tests/checks/check_limits.py
constants     gcc,python                   $PYTHON tests/gate/constants.py --check
manifests     python                       $PYTHON tests/checks/check_manifests.py
symbols       gcc,python                   $PYTHON tests/checks/check_symbols.py
callgraph     gcc,arm,python
              $PYTHON tests/checks/check_callgraph.py build/callgraph
header        gcc,g++,clang                sh tests/checks/check_header.sh
cross         arm                          sh tests/checks/check_cross.sh
figures       gcc,arm,riscv,python         $PYTHON port/qemu/figures.py
memory        arm                          sh tests/bench/rig_memory.sh
rig-ceres     gcc,g++,cmake,make,ceres,unity
              sh tests/bench/rig.sh check
real-rigs     gcc,cmake,unity,numpy,scipy
              preset_build gcc-double && preset_build gcc-float && $PYTHON tests/bench/real_rigs.py
real-points   gcc,cmake,unity,numpy
              preset_build gcc-double && $PYTHON tests/bench/real_points.py
format        clang-format                 sh tests/checks/check_format.sh
cppcheck      cppcheck                     sh tests/checks/check_cppcheck.sh
tidy          gcc,clang-tidy               sh tests/checks/check_tidy.sh
shell         nothing                      sh tests/checks/check_shell.sh
words         nothing                      sh tests/checks/check_words.sh
'

# What a need is: Debian's packages, each with a command that succeeds when it is there.
want_need() {
    case $1 in
    gcc)
        want gcc gcc --version
        want libc6-dev test -e /usr/include/stdio.h
        ;;
    g++) want g++ g++ --version ;;
    clang) want clang clang --version ;;
    cmake)
        want cmake cmake --version
        want ninja-build ninja --version
        ;;
    make) want make make --version ;;
    pkgconf) want pkgconf pkg-config --version ;;
    unity) want xz-utils xz --version ;; # and see below
    clang-format) want clang-format clang-format --version ;;
    clang-tidy) want clang-tidy clang-tidy --version ;;
    cppcheck) want cppcheck cppcheck --version ;;
    rust) want rustc rustc --version ;;
    ceres) want libceres-dev test -e /usr/include/ceres/ceres.h ;;
    arduino) want arduino-builder arduino-builder -version ;;
    venv) want python3-venv /usr/bin/python3 -c "import ensurepip" ;;
    arm)
        want gcc-arm-none-eabi arm-none-eabi-gcc --version
        want picolibc-arm-none-eabi \
            arm-none-eabi-gcc --specs=picolibc.specs -E -x c /dev/null
        want qemu-system-arm qemu-system-arm --version
        ;;
    riscv)
        want gcc-riscv64-unknown-elf riscv64-unknown-elf-gcc --version
        want picolibc-riscv64-unknown-elf \
            riscv64-unknown-elf-gcc --specs=picolibc.specs -E -x c /dev/null
        want qemu-system-misc qemu-system-riscv32 --version
        ;;
    mips)
        want gcc-mips-linux-gnu mips-linux-gnu-gcc --version
        want libc6-dev-mips-cross test -e /usr/mips-linux-gnu/include/stdio.h
        want qemu-user qemu-mips --version
        ;;
    time) want time /usr/bin/time --version ;;
    python) needs_python=yes ;;
    numpy | scipy)
        needs_python=yes
        modules="$modules $1"
        ;;
    nothing) ;;
    *)
        echo "tests/run.sh: a step needs $1, which is not in want_need." >&2
        exit 1
        ;;
    esac
}

set -u
cd "$(dirname "$0")/.." || exit 1
. tests/support/packages.sh

# One line a step.
steps=$(echo "$steps" | awk '/^[^ ]/ {printf "%s%s", n++ ? "\n" : "", $0}
                            /^ / {printf "%s", $0}
                            END {print ""}')
known=$(echo "$steps" | awk '{print $1}' | tr '\n' ' ')
for name in "$@"; do
    case " $known" in
    *" $name "*) ;;
    *)
        echo "There is no step $name. The steps are: $known" >&2
        exit 1
        ;;
    esac
done
asked=${*:-$known}

needs_python=
modules=
needs=$(echo "$steps" | awk -v asked=" $asked " 'index(asked, " " $1 " ") {print $2}' |
    tr ',' '\n' | sort -u)
for need in $needs; do
    want_need "$need"
done
# shellcheck disable=SC2086 -- a list of modules
if [ -n "$needs_python" ] && ! find_python $modules >/dev/null; then
    missing="$missing python3"
    for module in $modules; do
        missing="$missing python3-$module"
    done
fi
install_missing || exit 1

# A bare chroot has no /proc.
if [ ! -e /proc/self/maps ]; then
    echo "mounting /proc, which the sanitizers and rustc need"
    mount -t proc proc /proc ||
        echo "It cannot be mounted: steps that need it will fail." >&2
fi

# Unity comes from Debian's sources; where it cannot, CMake clones upstream's.
case " $(echo "$needs" | tr '\n' ' ')" in
*" unity "*)
    sh tests/support/get_unity.sh \
        "${XDG_CACHE_HOME:-${HOME:-/nowhere}/.cache}/rigcal/unity-2.5.1" 2>/dev/null
    if [ $? -eq 1 ]; then
        want git git --version
        want ca-certificates test -e /etc/ssl/certs/ca-certificates.crt
        install_missing || exit 1
    fi
    ;;
esac

if [ -n "$needs_python" ]; then
    # shellcheck disable=SC2086 -- a list of modules
    PYTHON=$(find_python $modules) || {
        echo "There is no Python 3 with these modules:$modules." >&2
        exit 1
    }
    export PYTHON
fi
jobs=$(nproc 2>/dev/null || echo 2)

preset_build() {
    drop_moved_build "build/$1"
    cmake --preset "$1" && cmake --build --preset "$1" -j "$jobs"
}

preset() {
    preset_build "$1" && ctest --preset "$1" -j "$jobs"
}

cli() {
    preset_build "$1" && RIGCAL_BIN=build/$1/rigcal $PYTHON tests/cli/test_cli.py
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
while read -r name needed command; do
    case " $asked " in
    *" $name "*) ;;
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

set -- $failed
if [ $# -eq 0 ]; then
    echo "All is well."
else
    echo "Failed: $*. The logs are in build/logs."
fi
echo "$passed passed, $# failed"
[ $# -eq 0 ]
