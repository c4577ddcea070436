#!/bin/sh
# Coverage of src/ by the unit tests and the regression tests in C: lines, branches, and the
# conditions of each decision (MC/DC), with clang 19.
#
#   sh tests/coverage/run.sh [double | float]
#
# Without a word both precisions. It builds build/coverage-double and build/coverage-float,
# runs their tests, and fails when something is not covered and not in exceptions.txt, or in
# exceptions.txt and covered. What is not covered and why is in build/coverage-*/coverage.txt.
set -eu
cd "$(dirname "$0")/../.."
. tests/support/packages.sh

case ${1:-both} in
both) precisions="double float" ;;
double | float) precisions=$1 ;;
*)
    echo "usage: sh tests/coverage/run.sh [double | float]" >&2
    exit 2
    ;;
esac

want clang-19 clang-19 --version
want libclang-rt-19-dev \
    test -e /usr/lib/llvm-19/lib/clang/19/lib/linux/libclang_rt.profile-x86_64.a
want llvm-19 llvm-cov-19 --version
want cmake cmake --version
want ninja-build ninja --version
install_missing
PYTHON=${PYTHON:-$(find_python)}

for precision in $precisions; do
    build=build/coverage-$precision
    drop_moved_build "$build"
    cmake --preset "coverage-$precision" >"$build.log"
    cmake --build --preset "coverage-$precision" >>"$build.log" 2>&1 || {
        tail -n 40 "$build.log"
        exit 1
    }
    # A decision that contains another one, as in !(a && b) || c, is not counted. The
    # objects are removed, so that the next build reports it again.
    if grep -B1 -A2 "unsupported MC/DC" "$build.log"; then
        rm -rf "$build"/CMakeFiles/rigcal.dir/src
        echo "The conditions above cannot be counted: write !a || !b for !(a && b)." >&2
        exit 1
    fi
    rm -rf "$build/profiles"
    LLVM_PROFILE_FILE=$PWD/$build/profiles/%p.profraw \
        ctest --preset "coverage-$precision" --exclude-regex '^names$' >"$build/ctest.log" 2>&1 || {
        tail -n 40 "$build/ctest.log"
        exit 1
    }
    # Links one program with the whole library, because llvm-cov cannot read every archive.
    echo "int main(void) { return 0; }" >"$build/whole.c"
    clang-19 -fprofile-instr-generate "$build/whole.c" -Wl,--whole-archive \
        "$build/librigcal.a" -Wl,--no-whole-archive -lm -o "$build/whole"
    llvm-profdata-19 merge -sparse "$build"/profiles/*.profraw -o "$build/all.profdata"
    rm -rf "$build/profiles"
    llvm-cov-19 export -format=text -instr-profile="$build/all.profdata" "$build/whole" \
        >"$build/coverage.json"
done
# shellcheck disable=SC2086 -- a list of words
$PYTHON tests/coverage/report.py $precisions
