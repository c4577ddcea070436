#!/bin/sh
# The library by each compiler, standard and option that it is promised for.
#
#   sh tests/ways/matrix.sh [rest] [SECONDS]
#                                   everything; writes tests/ways/MATRIX.md. By hand. It
#                                   continues where the last run ended: a line is not run again
#                                   if its sources and tests are as at the commit of its last
#                                   result. A line that has not begun after SECONDS (100000)
#                                   keeps its last result. With `rest`, every line that has a
#                                   result keeps it.
#   sh tests/ways/matrix.sh short   what CI has time for
#
# Each combination compiles src/ with the project's warnings as errors. Unit tests of
# build/gcc-double and build/gcc-float, which must be built, are linked with its library and
# run, and so is the gate. Where every object of a combination is the same, byte for byte, as
# that of an earlier one, the tests are not run again. The public headers are included by C
# and by C++ programs that take the address of every public function.
set -eu
cd "$(dirname "$0")/../.."
. tests/support/packages.sh

form=full
end=$(($(date +%s) + 100000))
is_rest=
case ${1-} in
short) form=short ;;
rest)
    is_rest=yes
    shift
    ;;
esac
case ${1-} in
[0-9]*) end=$(($(date +%s) + $1)) ;;
esac
out=$PWD/build/matrix
strict="-Wall -Wextra -Wpedantic -Wconversion -Wdouble-promotion -Wshadow -Werror"
tests="adjust bytes camera chain chance diagnose faults filter graph hostile judge join layout
    lens levenberg linalg locate match measure monitor neldermead p3p paper pose rig robust
    rotation score seeds spans spans_arcs store store_rig trial triangulate verdict watch"
# Link-time optimisation compiles the whole library for each program, which takes long. So
# only these tests are run.
tests_lto="lens measure pose rig store"
count=0

complain() {
    echo "matrix: $*" | tee -a "$out/bad.txt"
}

# What the results of the full form depend on, as one number.
state_of() {
    {
        cat src/* include/* tests/*.c tests/support/* tests/vectors/* tests/gate/gate.c \
            tests/gate/expected_*.txt tests/ways/matrix.sh
        gcc --version
        clang --version
        i686-linux-gnu-gcc --version
    } 2>/dev/null | sha256sum | cut -d' ' -f1
}

# If no line was run with the same state, nothing has been seen.
begin_folder() {
    state=$(state_of)
    commit=$(commit_of src include tests/*.c tests/support tests/vectors tests/gate)
    if [ "$form" = short ] || [ "$(cat "$out/state" 2>/dev/null)" != "$state" ]; then
        rm -rf "$out/seen"
    fi
    rm -f "$out/double.md" "$out/float.md" "$out/bad.txt" "$out"/small-*.txt
    mkdir -p "$out/seen"
    echo "$state" >"$out/state"
}

# row COMBINATION REAL RESULT: a line of the table
row() {
    printf '| %s | %s | %s | %s |\n' "$1" "$2" "$3" "$commit" | tee -a "$out/$2.md"
}

# keep REAL: the last row is a result
keep() {
    [ "$form" = short ] || tail -n 1 "$out/$1.md" >>"$out/kept.md"
}

# last_row REAL COMPILER FLAG...: the line's last result. It is from this run, from one that
# was interrupted, or from the table in the tree
last_row() {
    wanted=$1
    shift
    [ "$form" = short ] || cat tests/ways/MATRIX.md "$out/kept.md" 2>/dev/null |
        grep -F "| $* | $wanted | " | grep -v '| not run |' | tail -n 1
}

# is_enough ROW: whether nothing has changed since its commit, or it has to be enough
is_enough() {
    [ -n "$1" ] && { [ -n "$is_rest" ] || [ "$(date +%s)" -ge "$end" ] ||
        git diff --quiet "$(echo "$1" | sed 's/.*| \([^|]*\) |$/\1/')" -- src include \
            tests/*.c tests/support tests/vectors tests/gate 2>/dev/null; }
}

# define REAL: the options that set the precision
define() {
    [ "$1" = double ] || echo -DRIGCAL_USE_FLOAT=1
}

# compile FOLDER COMPILER FLAG...: each file of src/ to an object in FOLDER
compile() {
    folder=$1
    shift
    mkdir -p "$folder"
    root=$PWD
    # shellcheck disable=SC2086 -- warnings
    (cd "$folder" && printf '%s\n' "$root"/src/*.c |
        xargs "$@" $strict -I"$root/include" -DRIGCAL_BUILD -c) \
        >"$folder/compiler.txt" 2>&1
}

# The code of all objects in a folder, as one checksum.
code_of() {
    cat "$1"/*.o | sha256sum | cut -d' ' -f1
}

# run_tests FOLDER REAL COMPILER FLAG...: sets `failed` to the tests that fail
run_tests() {
    folder=$1
    built=build/gcc-$2
    shift 2
    failed=
    ran=0
    chosen=$tests
    case " $* " in
    *" -flto "*) chosen=$tests_lto ;;
    esac
    for name in $chosen; do
        objects=$(find "$built/tests/CMakeFiles/test_$name.dir" -name '*.o')
        case " $* $name" in
        *" -Os "*lens | *" -Os "*seeds) # they test what a build for size leaves out
            mkdir -p "$folder/small"
            objects=$folder/small/test_$name.o
            for_test "$real" gcc -std=c99 -DRIGCAL_FOR_SPEED=0 -c "tests/test_$name.c" \
                -o "$objects"
            ;;
        esac
        # shellcheck disable=SC2086 -- one object or more
        "$@" $objects \
            "$built/tests/librigcal_test_support.a" "$built/tests/libunity.a" \
            "$folder"/*.o -lm -o "$folder/test_$name" 2>>"$folder/compiler.txt"
        ran=$((ran + 1))
        "$folder/test_$name" >"$folder/test_$name.txt" 2>&1 || failed="$failed $name"
        rm "$folder/test_$name"
    done
}

# build_gate FOLDER REAL COMPILER FLAG...: FOLDER/gate, with a library that counts
build_gate() {
    counted=$1
    real=$2
    shift 2
    # shellcheck disable=SC2046 -- one option or none
    compile "$counted" "$@" $(define "$real") -I"$PWD/tests/support" \
        "-DRIGCAL_CONFIG_FILE=<count_hooks.h>" || return 1
    "$@" "build/gcc-$real/tests/CMakeFiles/gate.dir/gate/gate.c.o" "$counted"/*.o -lm \
        -o "$counted/gate"
}

# run_gate FOLDER REAL COMPILER FLAG...: its counts must be the expected ones. A build for size
# has other code (RIGCAL_FOR_SPEED): its counts must be those of that code with -O2.
run_gate() {
    expected=tests/gate/expected_$2.txt
    case " $* " in
    *" -Os "*)
        expected=$out/small-$2.txt
        if [ ! -e "$expected" ]; then
            build_gate "$out/small-$2" "$2" gcc -std=c99 -O2 $off -DRIGCAL_FOR_SPEED=0 || return 1
            "$out/small-$2/gate" >"$expected"
        fi
        ;;
    esac
    folder_of_line=$1
    shift
    build_gate "$folder_of_line/counted" "$@" || return 1
    # The depth of the stack depends on the options. All other counts must be equal.
    "$counted/gate" check "$expected" >"$counted/gate.txt" 2>&1 ||
        { grep -q '^gate: ' "$counted/gate.txt" &&
            ! grep ', now ' "$counted/gate.txt" | grep -qv '^stack\.'; }
}

# begin_line REAL COMPILER FLAG...: the library's objects, in $folder; fails if the line ends
# here: its last result is taken, or there is no time, or a file is not compiled
begin_line() {
    real=$1
    shift
    last=$(last_row "$real" "$@")
    if is_enough "$last"; then
        count=$((count + 1))
        echo "$last" | tee -a "$out/$real.md"
        return 1
    fi
    if [ "$(date +%s)" -ge "$end" ]; then
        printf '| %s | %s | not run | |\n' "$*" "$real" | tee -a "$out/$real.md"
        return 1
    fi
    count=$((count + 1))
    folder=$out/$real-$count
    rm -rf "$folder"
    # shellcheck disable=SC2046 -- one option or none
    if ! compile "$folder" "$@" $(define "$real"); then
        cat "$folder/compiler.txt"
        row "$*" "$real" "is not compiled"
        complain "$* does not compile"
        return 1
    fi
}

# end_line MORE COMPILER FLAG...: the row of what passed. A test that fails is a complaint,
# except with contraction.
end_line() {
    more=$1
    shift
    told=
    is_wrong=
    if [ -n "$failed" ]; then
        told=", **failed:$failed**"
        case " $* " in
        *" -ffp-contract=fast "*) ;;
        *)
            is_wrong=yes
            complain "$* in $real fails:$failed, $folder"
            ;;
        esac
    fi
    row "$*" "$real" "$((ran - $(echo "$failed" | wc -w))) of $ran pass$more$told"
    [ -n "$is_wrong" ] || keep "$real"
}

# combination REAL COMPILER FLAG...
combination() {
    begin_line "$@" || return 0
    shift
    code=$(code_of "$folder")
    if [ -e "$out/seen/$real-$code" ]; then
        row "$*" "$real" "the same objects as $(cat "$out/seen/$real-$code")"
        keep "$real"
        rm -r "$folder"
        return 0
    fi
    run_tests "$folder" "$real" "$@"
    if [ "$form" = full ]; then
        run_gate "$folder" "$real" "$@" || failed="$failed gate"
        ran=$((ran + 1))
    fi
    end_line "" "$@"
    if [ -z "$failed" ]; then
        echo "$*" >"$out/seen/$real-$code"
        rm -r "$folder"
    fi
}

# syntax REAL COMPILER FLAG...: the warnings of a standard
syntax() {
    real=$1
    shift
    count=$((count + 1))
    # shellcheck disable=SC2046,SC2086 -- options
    "$@" $strict $(define "$real") -Iinclude -DRIGCAL_BUILD -fsyntax-only src/*.c ||
        complain "$* in $real does not compile"
}

# refused REAL MESSAGE COMPILER FLAG...: every file of the library must say MESSAGE
refused() {
    real=$1
    message=$2
    shift 2
    for source in src/*.c; do
        if "$@" -Iinclude -DRIGCAL_BUILD -fsyntax-only "$source" 2>"$out/refused-$real.txt"; then
            complain "$* accepts $source"
        elif ! grep -q "$message" "$out/refused-$real.txt"; then
            complain "$* refuses $source without \"$message\""
        fi
    done
    count=$((count + 1))
    row "$*" "$real" "refused, by each file: $message"
}

# A program that includes every public header and links every public function.
write_user() {
    for header in include/*.h; do
        echo "#include \"${header#include/}\""
    done >"$out/user.c"
    functions=$(gcc -E -P -Iinclude -DRIGCAL_API=RIGCAL_DECLARED "$out/user.c" |
        tr '\n' ' ' | grep -o 'RIGCAL_DECLARED[^;(]*(' |
        sed 's/ *($//; s/.*[ *]//' | sort -u)
    {
        echo 'typedef void (*any_function)(void);'
        echo 'static const any_function all[] = {'
        for function in $functions; do
            echo "    (any_function)$function,"
        done
        echo '};'
        echo 'int main(void)'
        echo '{'
        echo '    unsigned i = 0;'
        echo '    for (; i < sizeof all / sizeof *all; i++) {'
        echo '        if (!all[i]) {'
        echo '            return 1;'
        echo '        }'
        echo '    }'
        echo '    return rigcal_sizeof_real() != sizeof(rigcal_real);'
        echo '}'
    } >>"$out/user.c"
    sed 's/(any_function)\(rigcal.*\),/reinterpret_cast<any_function>(\1),/' \
        "$out/user.c" >"$out/user.cpp"
    n_functions=$(echo "$functions" | wc -l)
}

# users REAL: programs in C and C++ that link the library of gcc -O2
users() {
    real=$1
    library=build/gcc-$real/librigcal.a
    cast=-Wno-cast-function-type # a list of functions of all types
    for std in c99 c11 c17 c2x c++11 c++14 c++17 c++20 c++2b; do
        case $std in
        c++*)
            compilers="g++ clang++"
            source=$out/user.cpp
            more="-Wold-style-cast -Wzero-as-null-pointer-constant"
            ;;
        *)
            compilers="gcc clang"
            source=$out/user.c
            more=
            ;;
        esac
        for compiler in $compilers; do
            count=$((count + 1))
            # shellcheck disable=SC2046,SC2086 -- options
            if "$compiler" -std=$std $strict $more $cast $(define "$real") -Iinclude \
                    "$source" "$library" -lm -o "$out/user-$real" && "$out/user-$real"; then
                row "a user's program, $compiler -std=$std" "$real" \
                    "includes every header, links $n_functions functions"
            else
                complain "a user's program by $compiler -std=$std in $real fails"
            fi
        done
    done
}

# for_test REAL COMPILER FLAG... FILE...: a call of the compiler as the tests' own build has it.
# gcc 12 vectorises the rounding to float away.
for_test() {
    float=$(define "$1")
    unity=$(unity_folder "build/gcc-$1")
    shift
    # shellcheck disable=SC2086 -- one option or none
    "$@" -O1 -fno-tree-slp-vectorize $float -I"$PWD/include" -I"$PWD/src" \
        -I"$PWD/tests/support" -I"$PWD/tests/vectors" -I"$unity" -DUNITY_INCLUDE_DOUBLE \
        -DUNITY_SUPPORT_64 -DUNITY_USE_COMMAND_LINE_ARGS "-DRIGCAL_DATA_DIR=\"$PWD/examples/data\""
}

# other REAL COMPILER FLAG...: another architecture of this processor; tests compiled for it
other() {
    begin_line "$@" || return 0
    shift
    failed=
    ran=0
    mkdir "$folder/support"
    for source in tests/support/test_*.c "$(unity_folder "build/gcc-$real")/unity.c"; do
        for_test "$real" "$@" -c "$source" -o "$folder/support/$(basename "$source" .c).o"
    done
    for name in $tests; do
        ran=$((ran + 1))
        for_test "$real" "$@" -static "tests/test_$name.c" "$folder"/support/*.o "$folder"/*.o \
            -lm -o "$folder/test_$name" >"$folder/test_$name.txt" 2>&1 &&
            "$folder/test_$name" >"$folder/test_$name.txt" 2>&1 || failed="$failed $name"
        rm -f "$folder/test_$name"
    done
    end_line ", no gate" "$@"
}

# Where the tests of a build found Unity.
unity_folder() {
    sed -n 's/^ *"file": "\(.*\)\/unity\.c",*$/\1/p' "$1/compile_commands.json"
}

# The library as CMake builds it with gcc for an x86 with FMA must not use it. With clang,
# -ffp-contract=off is enough.
built_for_fma() {
    [ "$(uname -m)" = x86_64 ] || return 0
    count=$((count + 1))
    cmake -S . -B "$out/fma" -DCMAKE_C_COMPILER=gcc -DCMAKE_BUILD_TYPE=Release \
        -DCMAKE_C_FLAGS="-O3 -march=haswell" -DRIGCAL_BUILD_EXAMPLES=OFF >"$out/fma.txt"
    cmake --build "$out/fma" --parallel 2 >>"$out/fma.txt"
    if objdump -d "$out/fma/librigcal.a" | grep -qE '\bvfn?m(add|sub)'; then
        complain "CMake with gcc -O3 -march=haswell fuses multiply-adds"
    fi
}

# whole REAL: the full form in one precision
whole() {
    real=$1
    for compiler in gcc clang; do
        combination "$real" $compiler -std=c99 -O2 -march=native -ffp-contract=fast
    done
    # gcc's vectoriser contracts: see include/rigcal_config.h.
    combination "$real" gcc -std=c99 -O3 -march=native -fno-tree-vectorize $off
    combination "$real" clang -std=c99 -O3 -march=native $off
    for level in -O0 -Os "-O2 -flto" -O3 -O1 -O2; do
        for compiler in gcc clang; do
            # shellcheck disable=SC2086 -- two options
            combination "$real" $compiler -std=c99 $level $off
        done
    done
    for std in c11 c17 c2x; do
        for compiler in gcc clang; do
            combination "$real" $compiler -std=$std -O2 $off
        done
    done
    other "$real" i686-linux-gnu-gcc -std=c99 -O2 -msse2 -mfpmath=sse $off
    # shellcheck disable=SC2046 -- one option or none
    refused "$real" "FLT_EVAL_METHOD is not 0" i686-linux-gnu-gcc -std=c99 $(define "$real")
    users "$real"
    echo "$count" >"$out/$real.count"
}

# Writes the last result for the tree.
write_table() {
    echo '# The library by each compiler, standard and option'
    echo
    echo "\`sh tests/ways/matrix.sh\` writes this file. A line's tests are the gate and"
    # shellcheck disable=SC2086 -- a list
    echo "$(echo $tests | wc -w) programs of unit tests, linked with the line's library; with \`-flto\` $(echo $tests_lto |
        wc -w). Warnings are errors: \`$strict\`."
    echo
    echo '| compiled by | precision | result | commit |'
    echo '| --- | --- | --- | --- |'
    cat "$out/double.md" "$out/float.md"
    echo
    echo "*$(date -u +%Y-%m-%d), $(gcc --version |
        sed -n 1p), $(clang --version | sed -n 1p), $(uname -m), $(sed -n \
        's/^model name.*: //p' /proc/cpuinfo | sed -n 1p)*"
}

begin_folder
write_user
off="-ffp-contract=off"
if [ "$form" = short ]; then
    for compiler in gcc clang; do
        syntax double $compiler -std=c11 $off
        syntax float $compiler -std=c2x $off
    done
    refused float "FLT_EVAL_METHOD is not 0" i686-linux-gnu-gcc -std=c99
    users float
    tests="bytes layout linalg lens pose store rig"
    combination double gcc -std=c99 -O0 $off
    built_for_fma
else
    whole double &
    whole float || complain "float stops"
    wait $! || complain "double stops"
    write_table >"$out/MATRIX.md"
    if [ ! -e "$out/bad.txt" ]; then
        mv "$out/MATRIX.md" tests/ways/MATRIX.md
        rm -f "$out/kept.md"
    fi
    count=$(($(cat "$out/double.count") + $(cat "$out/float.count")))
fi
[ ! -e "$out/bad.txt" ] || exit 1
echo "$count combinations: compilers, standards, options, programs in C and C++"
