#Compiles each public header alone, as C99 and as C++11, by gcc and clang, in double and
# float. Also compiles the whole library with the template of port/ as its configuration.
set -eu
cd "$(dirname "$0")/../.."

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

strict="-Wall -Wextra -Wpedantic -Wconversion -Wdouble-promotion -Wshadow -Werror"

count=0
compile() {
    if ! "$@" $strict -Iinclude -c -o "$work/out.o"; then
        echo "check_header: failed: $* $strict"
        exit 1
    fi
    count=$((count + 1))
}

for real in "" -DRIGCAL_USE_FLOAT=1; do
    for header in include/*.h; do
        echo "#include \"${header#include/}\"" >"$work/alone.c"
        cp "$work/alone.c" "$work/alone.cpp"
        for cc in gcc clang; do
            compile $cc -std=c99 $real "$work/alone.c"
        done
        for cxx in g++ clang++; do
            compile $cxx -std=c++11 -Wold-style-cast $real "$work/alone.cpp"
        done
    done
    for source in src/*.c; do
        compile gcc -std=c99 $real -Iport/template \
            '-DRIGCAL_CONFIG_FILE="rigcal_config_template.h"' "$source"
    done
done
echo "$count compilations, C99 and C++11, the template's configuration among them"
