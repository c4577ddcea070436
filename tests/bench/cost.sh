#!/bin/sh
# Thousands of instructions of rigcal_pose_solve, a Markdown table. Run by hand; wants
# valgrind.
#
#   sh tests/bench/cost.sh [COUNT]    COUNT scenes a column (64)
#
# Built by gcc -O2 in build/instructions.
set -eu
cd "$(dirname "$0")/../.."
count=${1:-64}
build=build/instructions

if ! command -v valgrind >/dev/null; then
    echo "cost.sh: there is no valgrind; install it to count." >&2
    exit 1
fi
mkdir -p build
. tests/support/packages.sh
drop_moved_build "$build"
if ! { cmake -S . -B "$build" -DCMAKE_C_COMPILER=gcc \
           -DCMAKE_BUILD_TYPE=Release -DCMAKE_C_FLAGS_RELEASE=-O2 \
           -DRIGCAL_REAL=double -DRIGCAL_BUILD_TESTS=ON \
           -DRIGCAL_BUILD_EXAMPLES=OFF &&
       cmake --build "$build" --target bench_cost; } >build/cost.log 2>&1; then
    cat build/cost.log >&2
    exit 1
fi

# Of a column, and "warm" or nothing.
thousands_of() {
    valgrind --tool=callgrind --toggle-collect=rigcal_pose_solve \
        --callgrind-out-file="$build/callgrind.out" \
        "$build/tests/bench_cost" "$1" "$count" $2 \
        >"$build/solve.txt" 2>"$build/callgrind.txt" || {
        cat "$build/callgrind.txt" >&2
        exit 1
    }
    total=$(sed -n 's/^totals: *//p' "$build/callgrind.out")
    echo $((total / count / 100)) | sed 's/\(.\)$/.\1/'
}

echo "Mean of $count solves on $(uname -m), gcc -O2, double; 0.5 px noise, 3 to 10 sizes"
echo "away. Warm: from the true pose, off by 2 degrees and 2 % of the distance."
echo
echo "| target | cold | warm |"
echo "| --- | ---: | ---: |"
for lens in "" "lens "; do
    for target in "tag 4" "planar 4" "planar 8" "planar 50" "general 4" "general 8" \
        "general 50"; do
        if [ "$lens$target" != "lens planar 4" ]; then
            cold=$(thousands_of "$lens$target" "")
            echo "| $lens$target | $cold | $(thousands_of "$lens$target" warm) |"
        fi
    done
done
