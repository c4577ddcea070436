#!/bin/sh
# Mean instructions of rigcal_pose_solve, and what the test of faults costs: two Markdown tables
# of BENCHMARKS.md. Run by hand; wants valgrind.
#
#   sh tests/bench/instructions.sh [COUNT]
#   sh tests/bench/instructions.sh faults [COUNT]   only the second, of COUNT rigs (20)
#
# Built by gcc -O2 in build/instructions; COUNT solves a line (default 200).
set -eu
cd "$(dirname "$0")/../.."
what=all
if [ "${1:-}" = faults ]; then
    what=faults
    shift
fi
count=${1:-200}
rigs=${1:-20}
build=build/instructions

if ! command -v valgrind >/dev/null; then
    echo "instructions.sh: there is no valgrind; install it to count." >&2
    exit 1
fi
mkdir -p build
. tests/support/packages.sh
drop_moved_build "$build"
if ! { cmake -S . -B "$build" -DCMAKE_C_COMPILER=gcc \
           -DCMAKE_BUILD_TYPE=Release -DCMAKE_C_FLAGS_RELEASE=-O2 \
           -DRIGCAL_REAL=double -DRIGCAL_BUILD_TESTS=ON \
           -DRIGCAL_BUILD_EXAMPLES=OFF &&
       cmake --build "$build" --target bench_pose bench_faults; } \
        >build/instructions.log 2>&1; then
    cat build/instructions.log >&2
    exit 1
fi

# A line of the table: its name, then the arguments of bench_pose solve.
row() {
    name=$1
    shift
    valgrind --tool=callgrind --toggle-collect=rigcal_pose_solve \
        --callgrind-out-file="$build/callgrind.out" \
        "$build/tests/bench_pose" solve "$@" \
        >"$build/solve.txt" 2>"$build/callgrind.txt" || {
        cat "$build/callgrind.txt" >&2
        exit 1
    }
    total=$(sed -n 's/^totals: *//p' "$build/callgrind.out")
    echo "| $name | $2 | $((total / count)) |"
}

# Instructions of a function in bench_faults cost. The evaluations are written to cost.txt.
instructions_of() {
    valgrind --tool=callgrind --toggle-collect="$1" \
        --callgrind-out-file="$build/callgrind.out" \
        "$build/tests/bench_faults" cost "$rigs" \
        >"$build/cost.txt" 2>"$build/callgrind.txt" || {
        cat "$build/callgrind.txt" >&2
        exit 1
    }
    sed -n 's/^totals: *//p' "$build/callgrind.out"
}

faults() {
    adjustment=$(instructions_of rigcal_rig_adjust)
    test=$(instructions_of rigcal_rig_faults)
    evaluations=$(cat "$build/cost.txt")
    hundredths=$((100 * test * evaluations / rigs / adjustment))
    echo "| mean of $rigs rigs of 4 cameras, 8 runs of 3 | instructions |"
    echo "| --- | ---: |"
    echo "| an evaluation of all views in an adjustment | $((adjustment / evaluations)) |"
    echo "| the test of all faults | $((test / rigs)) |"
    echo "| the same, in evaluations | $((hundredths / 100)).$(printf %02d $((hundredths % 100))) |"
}

if [ $what = faults ]; then
    faults
    exit
fi
"$build/tests/bench_pose" solve tag 4 1 | head -n 1
echo
echo "Mean of $count solves on $(uname -m), 0.5 px noise. Warm: from the true pose,"
echo "off by 2 degrees and 2 % of the distance."
echo
echo "| target | points | instructions a solve |"
echo "| --- | ---: | ---: |"
row tag tag 4 "$count"
row general general 4 "$count"
row general general 8 "$count"
row general general 50 "$count"
row "tag, warm" tag 4 "$count" warm
row "general, warm" general 4 "$count" warm
row "general, warm" general 8 "$count" warm
row "general, warm" general 50 "$count" warm
echo
faults
