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

# Thousands of instructions of a column; the second argument is "warm" or empty.
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

# PoseLib 3.0.0 (a69263d, C++, its own -O3) on such scenes, counted in the same way in one
# program with commit a75bf28 of rigcal: one answer (P3P, the best root refined), all roots
# refined, and a refinement from the warm start. Not counted again.
poselib='
tag 4|54.6|120.5|52.6
planar 4|55.2|116.1|53.0
planar 8|86.3|182.5|81.7
planar 50|305.6|677.6|294.3
general 4|61.4|147.4|60.7
general 8|79.0|187.2|76.0
general 50|267.3|601.1|264.6
lens tag 4|70.3|154.0|65.6
lens planar 8|121.7|254.2|111.3
lens planar 50|510.6|1098.4|460.2
lens general 4|78.9|178.7|73.8
lens general 8|112.8|255.2|103.2
lens general 50|445.9|944.8|406.6
'

echo "Mean of $count solves on $(uname -m), gcc -O2, double; 0.5 px noise, 3 to 10 sizes"
echo "away. Warm: from the true pose, off by 2 degrees and 2 % of the distance."
echo
echo "| target | cold | PoseLib, one answer | all roots | warm | PoseLib warm |"
echo "| --- | ---: | ---: | ---: | ---: | ---: |"
echo "$poselib" | while IFS='|' read -r target one all warm; do
    [ -n "$target" ] || continue
    echo "| $target | $(thousands_of "$target" "") | $one | $all | $(thousands_of "$target" warm) | $warm |"
done
