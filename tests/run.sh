#!/bin/sh
# Every test and check there is.
#
#   sh tests/run.sh            installs what is missing and runs all steps
#   sh tests/run.sh STEP...    runs only the steps named (first column below), and
#                              installs only what these need
#
# What the first step needs is installed first. What is still missing then is installed while
# steps run that do not need it.
#
# Prints one line for each step when it ends. Its log is build/logs/STEP.log. One step more
# than there are cores runs at a time, because steps wait for disks and networks too; but at
# most four. RIGCAL_LANES sets another number.

# The step, what it needs (see want_need), and its command. They begin in this order. Steps
# that need the same folder, build/NAME, run one after the other.
steps='
gcc-double    gcc,cmake,unity,build/gcc-double
              preset gcc-double
cortex-m0     arm,cmake,unity,build/cortex-m0
              preset cortex-m0
asan          gcc,cmake,unity,build/asan   preset asan
asan-float    gcc,cmake,unity              preset asan-float
paper         gcc,cmake,unity,python,build/gcc-double
              preset_build gcc-double && $PYTHON tests/checks/check_paper.py
figures       gcc,arm,riscv,cmake,unity,python,build/cortex-m0,build/cortex-m4f,build/cortex-m7,build/cortex-m7-double,build/cortex-m33,build/rv32imac,build/rv32imafc
              $PYTHON port/qemu/figures.py && $PYTHON port/qemu/monitor.py --check
cortex-m4f    arm,cmake,unity,build/cortex-m4f
              preset cortex-m4f
gcc-float     gcc,cmake,unity,build/gcc-float
              preset gcc-float
regression    gcc,clang,cmake,unity,rust,numpy,build/gcc-double,build/shared
              preset_build gcc-double && preset_build shared && regressions
cortex-m7     arm,cmake,unity,build/cortex-m7
              preset cortex-m7
m7-double     arm,cmake,unity,build/cortex-m7-double
              preset cortex-m7-double
cortex-m33    arm,cmake,unity,build/cortex-m33
              preset cortex-m33
rv32imac      riscv,cmake,unity,build/rv32imac
              preset rv32imac
rv32imafc     riscv,cmake,unity,build/rv32imafc
              preset rv32imafc
mips          mips,cmake,unity             preset mips
mips-double   mips,cmake,unity             preset mips-double
clang-double  gcc,clang,cmake,unity,build/gcc-double
              preset_build gcc-double && clang_library clang-double
clang-float   gcc,clang,cmake,unity
              clang_library clang-float
shared        gcc,cmake,unity              preset shared-tests
single-file   gcc,g++,clang,cmake,unity,python,build/gcc-double,build/gcc-float
              preset_build gcc-double && preset_build gcc-float && sh tests/ways/single_file.sh
coverage      llvm,cmake,unity,python      sh tests/coverage/run.sh
fuzz          libfuzzer,python             sh tests/fuzz/run.sh
ways          gcc,g++,cmake,arduino,venv   sh tests/ways/run.sh build/ways
hooks         gcc,clang,arm,cmake,unity,python,build/gcc-float
              preset_build gcc-float && sh tests/ways/hooks.sh build/hooks
consumers     gcc,g++,cmake,pkgconf        sh tests/consumers/run.sh build/consumers
install       gcc,cmake,make,pkgconf,python
              $PYTHON tests/checks/check_install.py
python        gcc,cmake,venv,opencv-doc,chromium,build/python
              sh port/python/tests/run.sh build/python
docs          gcc,cmake,venv,opencv-doc,chromium,build/python
              sh port/python/docs/run.sh build/docs
fleet         gcc,cmake,venv,build/python  sh examples/fleet/run.sh build/fleet
cli           gcc,cmake,unity,numpy,build/gcc-double
              cli gcc-double
cli-float     gcc,cmake,unity,numpy,build/gcc-float
              cli gcc-float
cli-asan      gcc,cmake,unity,numpy,build/asan
              cli asan
real-rigs     gcc,cmake,unity,numpy,scipy,build/gcc-double,build/gcc-float
              preset_build gcc-double && preset_build gcc-float && $PYTHON tests/bench/real_rigs.py
real-points   gcc,cmake,unity,numpy,build/gcc-double
              preset_build gcc-double && $PYTHON tests/bench/real_points.py
tables        gcc,cmake,unity,python,build/gcc-double
              preset_build gcc-double && $PYTHON tests/bench/tables.py --check
pictures      gcc,cmake,unity,python,build/gcc-double
              preset_build gcc-double && sh examples/pictures/run.sh --check build/gcc-double
scale         gcc,cmake,unity,numpy,time,build/gcc-double
              preset_build gcc-double && $PYTHON tests/bench/scale.py build/gcc-double/rigcal short && $PYTHON tests/long/lines.py short
ffi           gcc,cmake,rust,numpy,build/shared
              preset_build shared && sh examples/ffi/run.sh
firmware      gcc,arm,unity                sh examples/firmware/run.sh build/firmware
rig-ceres     gcc,g++,cmake,make,ceres,unity
              sh tests/bench/rig.sh check
mutation      gcc,cmake,unity,python,build/gcc-double
              preset_build gcc-double && $PYTHON tests/mutation/mutate.py
constants     gcc,python                   $PYTHON tests/gate/constants.py --check
symbols       gcc,cmake,unity,python,build/gcc-double,build/gcc-float
              preset_build gcc-double && preset_build gcc-float && $PYTHON tests/checks/check_symbols.py
vectors       numpy,scipy                  $PYTHON tests/vectors/make_vectors.py --check
tidy          gcc,clang-tidy               sh tests/checks/check_tidy.sh
callgraph     gcc,arm,python
              $PYTHON tests/checks/check_callgraph.py build/callgraph
cppcheck      cppcheck                     sh tests/checks/check_cppcheck.sh
static        gcc,python                   $PYTHON tests/checks/check_static.py short
proof         frama-c                      sh tests/proof/run.sh short
matrix        gcc,g++,clang,i686,cmake,unity,build/gcc-double,build/gcc-float
              preset_build gcc-double && preset_build gcc-float && sh tests/ways/matrix.sh short
readme        gcc,python                   $PYTHON tests/checks/check_readme.py && $PYTHON tests/bench/quoted.py --check
header        gcc,g++,clang                sh tests/checks/check_header.sh
cross         arm                          sh tests/checks/check_cross.sh
windows       mingw,cmake                  sh tests/checks/check_windows.sh build/windows
memory        arm                          sh tests/bench/rig_memory.sh
release       gcc,cmake,python             sh tests/checks/check_release.sh build/release-check
layers        gcc,python                   $PYTHON tests/checks/check_layers.py
limits        gcc,python                   $PYTHON tests/checks/check_limits.py
layout        python                       $PYTHON tests/checks/check_layout.py
manifests     python                       $PYTHON tests/checks/check_manifests.py
format        clang-format                 sh tests/checks/check_format.sh
shell         nothing                      sh tests/checks/check_shell.sh
words         nothing                      sh tests/checks/check_words.sh
'

# The needs: Debian packages, each with a command that succeeds if the package is there.
want_need() {
    case $1 in
    gcc)
        want gcc gcc --version
        want libc6-dev test -e /usr/include/stdio.h
        ;;
    g++) want g++ g++ --version ;;
    clang) want clang clang --version ;;
    libfuzzer)
        want clang-19 clang-19 --version
        want libclang-rt-19-dev \
            test -e /usr/lib/llvm-19/lib/clang/19/lib/linux/libclang_rt.fuzzer-x86_64.a
        ;;
    llvm)
        want clang-19 clang-19 --version
        want libclang-rt-19-dev \
            test -e /usr/lib/llvm-19/lib/clang/19/lib/linux/libclang_rt.profile-x86_64.a
        want llvm-19 llvm-cov-19 --version
        ;;
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
    frama-c) want frama-c-base frama-c -version ;;
    i686)
        want gcc-i686-linux-gnu i686-linux-gnu-gcc --version
        want libc6-dev-i386-cross test -e /usr/i686-linux-gnu/include/stdio.h
        ;;
    rust) want rustc rustc --version ;;
    ceres) want libceres-dev test -e /usr/include/ceres/ceres.h ;;
    arduino) want arduino-builder arduino-builder -version ;;
    opencv-doc) want opencv-doc test -e /usr/share/doc/opencv-doc/examples/data/left01.jpg ;;
    chromium) want chromium-headless-shell chromium-headless-shell --version ;;
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
    mingw) want gcc-mingw-w64-x86-64-win32 x86_64-w64-mingw32-gcc --version ;;
    time) want time /usr/bin/time --version ;;
    python) needs_python=yes ;;
    numpy | scipy)
        needs_python=yes
        modules="$modules $1"
        ;;
    nothing | build/*) ;;
    *)
        echo "tests/run.sh: a step needs $1, which is not in want_need." >&2
        exit 1
        ;;
    esac
}

set -u
cd "$(dirname "$0")/.." || exit 1
. tests/support/packages.sh
. tests/support/lanes.sh

# Puts each step on one line.
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
asked_steps=$(echo "$steps" | awk -v asked=" $asked " 'index(asked, " " $1 " ")')
needs=$(echo "$asked_steps" | awk '{print $2}' | tr ',' '\n' | sort -u)
first=$(echo "$asked_steps" | awk 'NR == 1 {print $2}')
later=
lacking=
for need in $needs; do
    before=$missing
    want_need "$need"
    case ",$first," in
    *",$need,"*) ;;
    *)
        [ "$missing" = "$before" ] || lacking="$lacking $need"
        later="$later${missing#"$before"}"
        missing=$before
        ;;
    esac
done
# shellcheck disable=SC2086 -- a list of modules
if [ -n "$needs_python" ] && ! find_python $modules >/dev/null; then
    missing="$missing python3"
    for module in $modules; do
        missing="$missing python3-$module"
    done
fi
[ -z "$later" ] || echo "beside the first steps:$later"
install_missing || exit 1

# A bare chroot has no /proc.
if [ ! -e /proc/self/maps ]; then
    echo "mounting /proc, which the sanitizers and rustc need"
    mount -t proc proc /proc ||
        echo "It cannot be mounted: steps that need it will fail." >&2
fi

# Unity comes from Debian's sources. If that fails, CMake clones the original.
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
mkdir -p build/logs && state=$(mktemp -d) || exit 1
trap 'rm -rf "$state"' EXIT

# Steps run side by side, in lanes, because most steps use only one core much of the time.
cores=$(nproc 2>/dev/null || echo 2)
most=${RIGCAL_LANES:-$((cores < 4 ? cores + 1 : 4))}
count=$(echo "$asked" | wc -w)
lanes=$((count < most ? count : most))
jobs=$(((cores + lanes - 1) / lanes))
export CMAKE_BUILD_PARALLEL_LEVEL="$jobs" CTEST_PARALLEL_LEVEL="$jobs"
# Steps read and copy the sources, so no new files may appear among them.
export PYTHONPYCACHEPREFIX="$PWD/build/pycache"

echo "$asked_steps" >"$state/steps"
began=$(date +%s)
if [ -n "$later" ]; then
    # The steps that need one of these packages have to wait.
    mkdir "$state/waiting" || exit 1
    awk -v lacking="$lacking " '{n = split($2, need, ",")
        for (i = 1; i <= n; i++) if (index(lacking, " " need[i] " ")) {print $1; next}}
        ' "$state/steps" | while read -r name; do
        : >"$state/waiting/$name"
    done
    missing=$later
    {
        # What fails is said, and the steps that need it fail.
        install_missing
        rm -rf "$state/waiting"
    } &
fi
run_steps "$lanes" "$state/steps" || exit 1

passed=0
failed=
for name in $(awk '{print $1}' "$state/steps"); do
    if [ -e "$state/ok/$name" ]; then
        passed=$((passed + 1))
    else
        failed="$failed $name"
    fi
done
# shellcheck disable=SC2086 -- a list of steps
set -- $failed
if [ $# -eq 0 ]; then
    echo "All is well."
else
    echo "Failed: $*. The logs are in build/logs."
fi
echo "$passed passed, $# failed, in $(($(date +%s) - began)) s ($(processor_seconds \
    "$state"/times/*) s of a processor)"
[ $# -eq 0 ]
