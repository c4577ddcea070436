#!/bin/sh
# rigcal_rig_adjust beside Ceres and SciPy, on the same rigs from the same starts: Markdown
# tables of DESIGN.md. Installs Ceres, SciPy and valgrind by apt where they are missing.
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
# deviations and Ceres's covariances to 1e-4.
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
    >/dev/null 2>&1 || true # else CMake clones it
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

# Instructions of one method.
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

# Lines "group;method;seconds;evaluations;sum;instructions" as a table. Of each group the
# least of either makes a ratio.
table() {
    awk -F ';' -v rig="$1" '
    function least(group, column, x) {
        x += 0
        if (x > 0 && (!((group, column) in best) || x < best[group, column])) {
            best[group, column] = x
        }
    }
    BEGIN {
        print "| " rig " | evaluations | CPU time, ms | over rigcal | 1000 instructions | over rigcal |"
        print "| --- | ---: | ---: | ---: | ---: | ---: |"
    }
    {
        if ($1 == "rigcal") {
            time = $3
            work = $6
        }
        least($1, "time", $3)
        least($1, "work", $6)
        printf "| %s%s | %d | %.3g | %.3g | ", (($1 == "SciPy") ? "SciPy, " : ($1 == "rigcal") ? "" : "Ceres, "), $2, $4, 1000 * $3, $3 / time
        if ($6 != "") {
            printf "%d | %.3g |\n", $6 / 1000, $6 / work
        } else {
            print "| |"
        }
    }
    END {
        print ""
        printf "rigcal takes of the best of Ceres by hand %.2f of the time and %.2f of the instructions (with covariance %.2f and %.2f); ", time / best["hand", "time"], work / best["hand", "work"], time / best["hand+cov", "time"], work / best["hand+cov", "work"]
        printf "of Ceres with automatic derivatives 1 / %.1f and 1 / %.1f (with covariance 1 / %.1f and 1 / %.1f); ", best["automatic", "time"] / time, best["automatic", "work"] / work, best["automatic+cov", "time"] / time, best["automatic+cov", "work"] / work
        printf "of SciPy 1 / %.0f of the time.\n", best["SciPy", "time"] / time
    }' "$build/all.txt"
}

sed -n 's/^model name[^:]*: */Processor: /p' /proc/cpuinfo | head -n 1
gcc --version | head -n 1
dpkg-query -W -f '${Package} ${Version}\n' libceres-dev python3-scipy valgrind \
    2>/dev/null || true
git log -1 --format='commit %h' 2>/dev/null || true
sed -n 's/^#define BENCH_RIG_SEED /Seed /p' tests/bench/bench_rigs.h
echo "CPU time: the least of $repeats runs, of SciPy the least of 3."
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
    done <"$build/compare.txt" >"$build/all.txt"
    sed 's/^/SciPy;/; s/$/;/' "$build/scipy.txt" >>"$build/all.txt"
    echo
    table "$(echo "$rig" | sed 's/,/ x /g')"
done
