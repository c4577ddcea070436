#!/bin/sh
# Lays the library out as a package manager wants it.
#
#   sh port/package.sh WAY FOLDER [URL]
#
# WAY is single_file or a folder beside this script that holds a manifest: arduino,
# cmsis-pack, conan, esp-idf, meson, platformio, zephyr. FOLDER is made and must not
# hold anything. URL is where you publish the package; only the manifests of arduino
# and cmsis-pack have a place for it.
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)

usage() {
    sed -n '2,/^set/{/^set/d;s/^# \{0,1\}//p}' "$0" >&2
    exit 2
}

[ $# -eq 2 ] || [ $# -eq 3 ] || usage
way=$1
out=$2
url=${3:-}
case $way in
arduino | cmsis-pack | conan | esp-idf | meson | platformio | zephyr | single_file) ;;
*) usage ;;
esac
if [ -n "$(ls -A "$out" 2>/dev/null)" ]; then
    echo "package.sh: $out is not empty" >&2
    exit 1
fi
mkdir -p "$out"
out=$(cd "$out" && pwd)

if [ "$way" = single_file ]; then
    "${PYTHON:-python3}" "$root/port/single_file/amalgamate.py" "$out"
    exit
fi

part() {
    sed -n "s/^#define RIGCAL_VERSION_$1 *\([0-9]*\)$/\1/p" "$root/include/rigcal.h"
}
version=$(part MAJOR).$(part MINOR).$(part PATCH)

# One line of the manifest a source.
list=$out/sources
for source in "$root"/src/*.c; do
    name=src/$(basename "$source")
    case $way in
    cmsis-pack) echo "        <file category=\"sourceC\" name=\"$name\"/>" ;;
    meson) echo "    '$name'," ;;
    esac
done >"$list"

cp "$root/LICENSE" "$out"
(cd "$root/port/$way" && find . -type f ! -name '*.pyc') | while read -r file; do
    mkdir -p "$out/$(dirname "$file")"
    sed -e "/@SOURCES@/r $list" -e "/@SOURCES@/d" -e "s|@VERSION@|$version|g" \
        -e "s|@URL@|$url|g" "$root/port/$way/$file" >"$out/$file"
done
rm "$list"

case $way in
arduino)
    # One folder of sources, and no compiler options: the choices are a header's.
    cp "$root"/include/*.h "$root"/src/*.[ch] "$out/src"
    sed '/^#ifdef RIGCAL_CONFIG_FILE/i\
#ifndef RIGCAL_CONFIG_FILE\
#define RIGCAL_CONFIG_FILE "rigcal_arduino.h"\
#endif' "$root/include/rigcal_config.h" >"$out/src/rigcal_config.h"
    ;;
*)
    cp -R "$root/include" "$root/src" "$out"
    ;;
esac
case $way in
conan)
    cp "$root/CMakeLists.txt" "$out"
    cp "$root/tests/consumers/main.c" "$out/test_package"
    ;;
meson)
    cp "$root/tests/consumers/main.c" "$out"
    ;;
esac
echo "rigcal $version for $way in $out"
