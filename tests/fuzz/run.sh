#!/bin/sh
# The fuzz harnesses, with the address and undefined-behaviour sanitizers.
#
#   sh tests/fuzz/run.sh                   each from the corpus in double, with the same inputs
#                                          each time; a step of CI
#   sh tests/fuzz/run.sh float             the same in float
#   sh tests/fuzz/run.sh msan              the inputs found so far, under the memory sanitizer
#   sh tests/fuzz/run.sh campaign SECONDS [HARNESS...]
#                                          goes on where the last campaign ended: the inputs
#                                          found stay in build/fuzz/corpus. Each part ends with
#                                          a line in tests/fuzz/RESULTS.md
#
# Everything is built in build/fuzz. A finding ends the run: its input is in build/fuzz.
set -eu
cd "$(dirname "$0")/../.."
. tests/support/packages.sh

what=${1:-double}
harnesses=$(ls tests/fuzz/fuzz_*.c | sed 's|.*/fuzz_||; s|\.c$||; /^rigs$/d; /^narrow$/d')
case $what in
double | msan) ;;
float) harnesses=$(echo "$harnesses" | sed '/^ways$/d') ;; # ways has both precisions
campaign)
    if [ $# -lt 2 ]; then
        echo "usage: sh tests/fuzz/run.sh campaign SECONDS [HARNESS...]" >&2
        exit 2
    fi
    seconds=$2
    shift 2
    [ $# -eq 0 ] || harnesses=$*
    ;;
*)
    echo "usage: sh tests/fuzz/run.sh [float | msan | campaign SECONDS [HARNESS...]]" >&2
    exit 2
    ;;
esac

want clang-19 clang-19 --version
want libclang-rt-19-dev sh -c 'test -e /usr/lib/llvm-19/lib/clang/19/lib/linux/libclang_rt.fuzzer-x86_64.a'
install_missing

build=build/fuzz/$what
sanitize=address,undefined
defines=
case $what in
campaign) build=build/fuzz/double ;;
float) defines=-DRIGCAL_USE_FLOAT=1 ;;
msan) sanitize=memory ;;
esac
flags="-std=c99 -g -O1 -Wall -Wextra -Werror -fno-sanitize-recover=all -Iinclude -Iexamples"

# build_library FOLDER DEFINES [SANITIZERS]: FOLDER/library.a. The objects are built again if
# a source or a header is newer.
build_library() {
    mkdir -p "$1"
    newest=$(find src include -type f -newer "$1/library.a" 2>/dev/null || echo none)
    if [ -n "$newest" ]; then
        printf '%s\n' src/*.c | xargs -P "${CMAKE_BUILD_PARALLEL_LEVEL:-2}" -I{} sh -c '
            clang-19 $1 -fsanitize=fuzzer-no-link$2 -c "$3" -o "$4/$(basename "$3" .c).o"
        ' compile "$flags $2" "${3-,$sanitize}" {} "$1"
        rm -f "$1/library.a"
        ar rcs "$1/library.a" "$1"/rigcal_*.o
    fi
}

# The library in float as one object, of which only the functions of fuzz_narrow.h are visible.
# In CI it has no sanitizers: there the step asan-float has them.
build_narrow() {
    also=,$sanitize
    [ "$what" != double ] || also=
    narrow=$build-narrow${also:+-checked}
    build_library "$narrow" -DRIGCAL_USE_FLOAT=1 "$also"
    # shellcheck disable=SC2086 -- flags
    clang-19 $flags -DRIGCAL_USE_FLOAT=1 -fsanitize=fuzzer-no-link$also \
        -c tests/fuzz/fuzz_narrow.c -o "$narrow/fuzz_narrow.o"
    ld -r -o "$narrow/narrow.o" "$narrow/fuzz_narrow.o" "$narrow/library.a"
    objcopy --wildcard --keep-global-symbol='narrow_*' "$narrow/narrow.o"
}

build_library "$build" "$defines"
flags="$flags $defines"
for shared in fuzz fuzz_rigs; do
    # shellcheck disable=SC2086 -- flags
    clang-19 $flags -fsanitize=fuzzer,$sanitize -c "tests/fuzz/$shared.c" -o "$build/$shared.o"
done
# In CI the inputs are the same each time, whatever campaigns have found.
case $what in
double | float)
    corpus=$build/corpus
    rm -rf "$corpus"
    ;;
*) corpus=build/fuzz/corpus ;;
esac
mkdir -p "$corpus"
/usr/bin/python3 tests/fuzz/make_corpus.py "$corpus"

# The number of inputs of a harness in CI: about 3 seconds on an idle core.
runs_of() {
    case $1 in
    rotation | neldermead) echo 150000 ;;
    camera | store) echo 75000 ;;
    adjust | measure | rig) echo 20000 ;;
    csv) echo 10000 ;;
    diagnose | ways) echo 2000 ;;
    *) echo 6000 ;;
    esac
}

# The number after the name $1 in what libFuzzer prints at the end of `log`.
figure() {
    sed -n "s/^stat::$1: *//p" "$log"
}

run() {
    log=$build/$1.log
    program=$build/fuzz_$1
    # The reader is a part of the command line, and fuzz_csv.c includes it.
    case $1 in
    csv) others="examples/cli_input.c examples/cli_names.c examples/cli_foreign.c examples/cli_os.c" ;;
    ways)
        build_narrow
        others="$build/fuzz_rigs.o $narrow/narrow.o"
        ;;
    *) others=$build/fuzz_rigs.o ;;
    esac
    # shellcheck disable=SC2086 -- lists of flags and of sources
    clang-19 $flags -fsanitize=fuzzer,$sanitize "tests/fuzz/fuzz_$1.c" "$build/fuzz.o" \
        $others "$build/library.a" -lm -o "$program"
    found=$corpus/$1
    name=$1
    set -- "$program" -max_len=8192 -timeout=100 -print_final_stats=1 \
        -artifact_prefix=build/fuzz/"$name"-
    case $what in
    campaign) set -- "$@" -max_total_time="$seconds" "$found" ;;
    msan) set -- "$@" -runs=0 "$found" ;;
    *) # The seed fixes the inputs if they are read in one order, and if the program is
        # loaded at one address: libFuzzer decides by addresses which inputs it keeps.
        list=$(find "$found" -type f | LC_ALL=C sort | paste -s -d , -)
        rm -rf "$build/empty"
        mkdir -p "$build/empty"
        set -- "$@" -seed=2 -runs="$(runs_of "$name")" -seed_inputs="$list" "$build/empty"
        ! setarch -R true 2>/dev/null || set -- setarch -R "$@"
        ;;
    esac
    if ! "$@" >"$log" 2>&1; then
        grep -a -e "a promise is broken" -e "ERROR" -e "runtime error" "$log" || tail "$log"
        echo "$name: a finding; its input is build/fuzz/$name-*, the log $log"
        return 1
    fi
    executed=$(figure number_of_executed_units)
    rate=$(figure average_exec_per_sec)
    printf '%-10s %9d executions, %6d a second\n' "$name" "$executed" "$rate"
    if [ "$what" = campaign ]; then
        hours=$(awk -v rate="$rate" 'BEGIN {printf "%.1f", (rate > 0) ? 1e9 / rate / 3600 : 0}')
        printf '| %s | %s | %s | %s | %s | %s | none |\n' "$(date +%F)" \
            "$(commit_of src include)" "$name" "$executed" "$rate" "$hours" \
            >>tests/fuzz/RESULTS.md
    fi
}

for harness in $harnesses; do
    run "$harness"
done
