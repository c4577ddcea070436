#!/bin/sh
# rigcal_rig_adjust beside Ceres and SciPy, on the same rigs from the same starts: a Markdown
# table of BENCHMARKS.md. Installs Ceres, SciPy and valgrind by apt where they are missing.
#
#   sh tests/bench/rig.sh          all three rigs, instructions and CPU time; by hand, some
#                                  minutes
#   sh tests/bench/rig.sh check    the two small rigs with Ceres alone, nothing counted: that
#                                  both end in the same minimum, with the same covariance; a
#                                  step of CI
#
# Built by gcc and g++ -O2 in build/rig, Ceres and SciPy as Debian ships them, one thread.
# The rigs are those of bench_rigs.h: cameras x placements x points. Nothing is printed of a
# rig unless all sums of squares agree to 1e-8, the cameras' poses to 0.01 of their standard
# deviations and Ceres's covariances to 1e-4. Every method's line is in build/rig/all_*.txt,
# those of SciPy that do not end there are named on stderr.
set -eu
cd "$(dirname "$0")/../.."
. tests/support/packages.sh
what=${1:-all}
build=build/rig
bench=$build/tests/bench_ceres
repeats=10
case $what in
all) rigs="2,7,54 4,20,20 8,50,30" ;;
check) rigs="2,7,54 4,20,20" ;;
*)
    echo "usage: sh tests/bench/rig.sh [check]" >&2
    exit 2
    ;;
esac

want gcc gcc --version
want g++ g++ --version
want cmake cmake --version
want make make --version
want libceres-dev test -e /usr/include/ceres/ceres.h
if [ "$what" = all ]; then
    want valgrind valgrind --version
    want python3-scipy /usr/bin/python3 -c "import scipy"
fi
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
           -DRIGCAL_BENCH_CERES=ON &&
       cmake --build "$build" --target bench_ceres bench_rig; } \
        >build/rig.log 2>&1; then
    cat build/rig.log >&2
    exit 1
fi
OMP_NUM_THREADS=1
OPENBLAS_NUM_THREADS=1
export OMP_NUM_THREADS OPENBLAS_NUM_THREADS

if [ "$what" = check ]; then
    for rig in $rigs; do
        # shellcheck disable=SC2046 -- three numbers
        "$bench" compare $(echo "$rig" | tr ',' ' ') >"$build/compare.txt"
        echo "$rig: $(wc -l <"$build/compare.txt") methods agree"
    done
    exit 0
fi

# The instructions of one method.
count() {
    # shellcheck disable=SC2086 -- three numbers
    valgrind --tool=callgrind --toggle-collect=bench_call \
        --callgrind-out-file="$build/callgrind.out" "$bench" solve $1 "$2" \
        >"$build/solve.txt" 2>"$build/callgrind.txt" || {
        cat "$build/callgrind.txt" >&2
        exit 1
    }
    sed -n 's/^totals: *//p' "$build/callgrind.out"
}

# Of lines "group;method;seconds;evaluations;sum;instructions" the best of each group, by
# instructions, or by time where there are none, as rows of the table; a ratio is rigcal's
# over the other's.
rows() {
    awk -F ';' -v rig="$1" '
    {
        price = ($6 != "") ? $6 : $3
        if (!($1 in best)) {
            groups[++n] = $1
        }
        if (!($1 in best) || price + 0 < best[$1]) {
            best[$1] = price + 0
            name[$1] = $2
            time[$1] = 1000 * $3
            evaluations[$1] = $4
            work[$1] = $6
        }
    }
    END {
        for (i = 1; i <= n; i++) {
            g = groups[i]
            from = (g == "rigcal") ? "" : (g == "SciPy") ? "SciPy: " : "Ceres: "
            printf "| %s | %s%s | %d | %.3g | ", rig, from, name[g], evaluations[g], time[g]
            if (g == "rigcal") {
                printf "| %d | |\n", work[g] / 1000
            } else if (work[g] != "") {
                printf "%.3g | %d | %.3g |\n", time["rigcal"] / time[g], work[g] / 1000,
                    work["rigcal"] / work[g]
            } else {
                printf "%.3g | | |\n", time["rigcal"] / time[g]
            }
        }
    }' "$2"
}

sed -n 's/^model name[^:]*: */Processor: /p' /proc/cpuinfo | head -n 1
gcc --version | head -n 1
dpkg-query -W -f '${Package} ${Version}\n' libceres-dev python3-scipy valgrind \
    2>/dev/null || true
git log -1 --format='commit %h' 2>/dev/null || true
sed -n 's/^#define BENCH_RIG_SEED /Seed /p' tests/bench/bench_rigs.h
echo "CPU time: the least of $repeats runs, of SciPy the least of 3."
echo
echo "| rig | the best of its kind | evaluations | CPU time, ms | ratio | 1000 instructions | ratio |"
echo "| --- | --- | ---: | ---: | ---: | ---: | ---: |"
for rig in $rigs; do
    numbers=$(echo "$rig" | tr ',' ' ')
    # shellcheck disable=SC2086 -- three numbers
    "$bench" compare $numbers $repeats >"$build/compare.txt"
    # shellcheck disable=SC2086
    "$build/tests/bench_rig" print $numbers >"$build/problem.txt"
    /usr/bin/python3 tests/bench/rig_scipy.py <"$build/problem.txt" >"$build/scipy.txt"
    while IFS=';' read -r method seconds evaluations sum; do
        group=${method%%,*}
        case $method in *+cov) group=$group+cov ;; esac
        instructions=$(count "$numbers" "$method")
        echo "$group;$method;$seconds;$evaluations;$sum;$instructions"
    done <"$build/compare.txt" >"$build/all_$rig.txt"
    sed 's/^/SciPy;/; s/$/;/' "$build/scipy.txt" >>"$build/all_$rig.txt"
    rows "$(echo "$rig" | sed 's/,/ x /g')" "$build/all_$rig.txt"
done
