#!/bin/sh
# Compiler options that break the library stop its compilation, with a message that names
# them. If the compiler does not report an option to the code, CMake refuses it. Other
# options pass.
#
#   sh tests/regression/compiler_options.sh FOLDER
set -eu
out=$1
count=0
bad=0

complain() {
    echo "compiler_options: $*"
    bad=1
}

# compiles COMPILER OPTION...: status 0 if the compiler accepts src/rigcal_linalg.c
compiles() {
    compiler=$1
    shift
    count=$((count + 1))
    "$compiler" -std=c99 -O2 -Wall -Wextra -Wpedantic -Werror -Iinclude \
        -DRIGCAL_BUILD "$@" -fsyntax-only src/rigcal_linalg.c \
        >"$out/compiler.txt" 2>&1
}

# Only if the compiler knows an option does its refusal mean something.
knows() {
    compiler=$1
    shift
    "$compiler" -Werror "$@" -c "$out/empty.c" -o "$out/object.o" 2>/dev/null
}
echo 'extern int x;' >"$out/empty.c"

passes() {
    knows "$@" || return 0
    compiles "$@" || { complain "$* is refused:"; cat "$out/compiler.txt"; }
}

# refused MESSAGE COMPILER OPTION...
refused() {
    message=$1
    shift
    knows "$@" || { echo "not known here: $*"; return 0; }
    if compiles "$@"; then
        complain "$* is accepted"
    elif ! grep -q "$message" "$out/compiler.txt"; then
        complain "$* is refused without \"$message\":"
        cat "$out/compiler.txt"
    fi
}

finite="no number is NaN or infinite"
reorder="told to reorder arithmetic"
digits="FLT_EVAL_METHOD is not 0"
for real in -DRIGCAL_USE_FLOAT=0 -DRIGCAL_USE_FLOAT=1; do
    for cc in gcc clang; do
        compiles $cc $real || { complain "$cc $real:"; cat "$out/compiler.txt"; }
        passes $cc $real -O3
        passes $cc $real -fno-math-errno
        passes $cc $real -fno-trapping-math
        passes $cc $real -ffp-contract=fast
        passes $cc $real -ffast-math -fno-fast-math
        passes $cc $real -std=gnu11
        passes $cc $real -std=gnu2x
        # FLT_EVAL_METHOD is 16
        passes $cc $real -mavx512fp16
        passes $cc $real -std=gnu2x -mavx512fp16
        for option in -ffast-math -Ofast -ffinite-math-only -ffp-model=fast; do
            refused "$finite" $cc $real $option
        done
        refused RIGCAL_USE_FLOAT=1 $cc $real -DRIGCAL_REAL=float
        refused RIGCAL_USE_FLOAT=1 $cc $real -DRIGCAL_REAL=double
    done
    refused "$digits" gcc $real -mfpmath=387
    refused "$digits" clang-15 $real -ffp-eval-method=extended
    if [ "$(gcc -dumpversion | cut -d. -f1)" -ge 12 ]; then
        for option in -funsafe-math-optimizations -freciprocal-math -fno-signed-zeros \
            "-fassociative-math -fno-signed-zeros -fno-trapping-math"; do
            # shellcheck disable=SC2086 -- several options
            refused "$reorder" gcc $real $option
        done
    fi
    # Half precision in registers, and cores without an FPU.
    for core in "cortex-m0" "cortex-m4 -mfloat-abi=hard -mfpu=fpv4-sp-d16" \
        "cortex-m55 -mfloat-abi=hard"; do
        # shellcheck disable=SC2086 -- several options
        passes arm-none-eabi-gcc --specs=picolibc.specs -mthumb -mcpu=$core $real
    done
done
refused rc_not_with_fsingle_precision_constant gcc -fsingle-precision-constant
passes gcc -DRIGCAL_USE_FLOAT=1 -fsingle-precision-constant
refused "must be 1 for float or 0 for double" gcc -DRIGCAL_USE_FLOAT=2
for source in src/*.c; do
    count=$((count + 1))
    ! gcc -std=c99 -ffinite-math-only -Iinclude -fsyntax-only "$source" \
        2>"$out/compiler.txt" || complain "$source alone accepts -ffinite-math-only"
done

# The first program of a port detects an option that no compiler reports.
count=$((count + 1))
clang -O1 -fno-honor-nans -Iinclude port/template/main_template.c src/*.c -lm \
    -o "$out/template"
if "$out/template" >"$out/template.txt"; then
    complain "main_template.c finds -fno-honor-nans in order"
elif ! grep -q NaN "$out/template.txt"; then
    complain "main_template.c says of -fno-honor-nans: $(cat "$out/template.txt")"
fi

# Code of a user may be compiled with any option.
echo '#include "rigcal.h"' >"$out/user.c"
gcc -ffast-math -Iinclude -c "$out/user.c" -o "$out/object.o" ||
    complain "rigcal.h refuses -ffast-math of a user's file"
if gcc -DRIGCAL_REAL=float -Iinclude -c "$out/user.c" -o "$out/object.o" \
        2>"$out/compiler.txt"; then
    complain "rigcal.h accepts -DRIGCAL_REAL=float of a user's file"
fi

# configured FLAGS [ARGUMENT...]: status 0 if CMake accepts the flags
configured() {
    flags=$1
    shift
    count=$((count + 1))
    rm -f "$out/cmake/CMakeCache.txt" # what CMake found out about the compiler stays
    cmake -S . -B "$out/cmake" -DCMAKE_C_COMPILER=clang -DRIGCAL_BUILD_TESTS=OFF \
        -DCMAKE_C_FLAGS="$flags" "$@" >"$out/cmake.txt" 2>&1
}
for flags in -funsafe-math-optimizations -fassociative-math -freciprocal-math \
    -fno-signed-zeros -fno-honor-nans -fno-honor-infinities \
    "-fno-associative-math -O2 -fassociative-math -g"; do
    if configured "$flags"; then
        complain "CMake accepts $flags"
    elif ! tr -s '\n ' ' ' <"$out/cmake.txt" | grep -q "flags hold -f"; then
        complain "CMake refuses $flags without saying why:"
        cat "$out/cmake.txt"
    fi
done
if configured "" -DCMAKE_BUILD_TYPE=Own -DCMAKE_C_FLAGS_OWN="-O2 -freciprocal-math"; then
    complain "CMake accepts -freciprocal-math of a build type"
fi
for flags in "" "-O3 -g" "-fassociative-math -fno-associative-math" "-fhonor-nans"; do
    configured "$flags" || { complain "CMake refuses $flags:"; cat "$out/cmake.txt"; }
done

[ $bad -eq 0 ] || exit 1
echo "$count builds: each is refused or passes as include/rigcal_config.h tells"
