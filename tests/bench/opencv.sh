#!/bin/sh
# rigcal_pose_solve beside the pose solvers of OpenCV: Markdown tables of BENCHMARKS.md.
# By hand: it installs 350 MB of Debian packages if they are missing.
#
#   sh tests/bench/opencv.sh [SCENES]
#
# Built by gcc -O2 in build/opencv, OpenCV as Debian ships it. SCENES a line (default
# 1000, some ten minutes).
set -eu
cd "$(dirname "$0")/../.."
. tests/support/packages.sh
scenes=${1:-1000}
solves=200
build=build/opencv
bench=$build/tests/bench_opencv

want gcc gcc --version
want g++ g++ --version
want cmake cmake --version
want make make --version
want valgrind valgrind --version
want libopencv-calib3d-dev test -e /usr/include/opencv4/opencv2/calib3d.hpp
install_missing >&2
sh tests/support/get_unity.sh \
    "${XDG_CACHE_HOME:-${HOME:-/nowhere}/.cache}/rigcal/unity-2.5.1" \
    >/dev/null 2>&1 || true # otherwise CMake clones it
mkdir -p build
drop_moved_build "$build"
if ! { cmake -S . -B "$build" -DCMAKE_C_COMPILER=gcc -DCMAKE_CXX_COMPILER=g++ \
           -DCMAKE_BUILD_TYPE=Release -DCMAKE_C_FLAGS_RELEASE=-O2 \
           -DCMAKE_CXX_FLAGS_RELEASE=-O2 -DRIGCAL_REAL=double \
           -DRIGCAL_BUILD_TESTS=ON -DRIGCAL_BUILD_EXAMPLES=OFF \
           -DRIGCAL_BENCH_OPENCV=ON &&
       cmake --build "$build" --target bench_opencv; } \
        >build/opencv.log 2>&1; then
    cat build/opencv.log >&2
    exit 1
fi

# Instructions and allocations of one method: "TOTAL / ALLOCATIONS".
count() {
    valgrind --tool=callgrind --toggle-collect=bench_call \
        --callgrind-out-file="$build/callgrind.out" \
        "$bench" solve "$1" "$2" "$3" "$solves" \
        >"$build/solve.txt" 2>"$build/callgrind.txt" || {
        cat "$build/callgrind.txt" >&2
        exit 1
    }
    total=$(sed -n 's/^totals: *//p' "$build/callgrind.out")
    echo "$((total / solves / 1000)) / $(cat "$build/solve.txt")"
}

# One cell of the table; empty if the method is not defined.
cell() {
    if "$bench" methods "$1" "$2" | grep -qxF "$3"; then
        count "$1" "$2" "$3"
    fi
}

# A line for each method that is defined for a tag: these are all methods.
counts() {
    "$bench" methods tag 4 | while read -r method; do
        line="| $method |"
        for target in "tag 4" "planar 8" "general 4" "general 8" "general 50"; do
            # shellcheck disable=SC2086 -- a family and a number
            number=$(cell $target "$method") || exit 1
            line="$line $number |"
        done
        echo "$line"
    done
}

sed -n 's/^model name[^:]*: */Processor: /p' /proc/cpuinfo | head -n 1
gcc --version | head -n 1
dpkg-query -W -f '${Package} ${Version}\n' libopencv-calib3d-dev 2>/dev/null ||
    true
echo
"$bench" targets "$scenes"
echo
"$bench" noises "$scenes"
echo
"$bench" three "$scenes"
echo
echo "1000 instructions / allocations a solve, mean of $solves solves, 0.5 px noise, 3"
echo "to 30 sizes away:"
echo
echo "| method | tag, 4 | planar, 8 | general, 4 | general, 8 | general, 50 |"
echo "| --- | ---: | ---: | ---: | ---: | ---: |"
counts
