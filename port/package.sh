#!/bin/sh
# Lays the library out as a package manager wants it.
#
#   sh port/package.sh WAY FOLDER [URL]
#
# WAY is single_file or a folder beside this script that holds a manifest: arduino,
# cmsis-pack, conan, esp-idf, meson, platformio, zephyr. FOLDER is made; if it exists, it
# must be empty. After a failure it is as it was before. URL is where you publish the
# package; cmsis-pack needs it, and arduino has a place for it.
#
# A shell is enough, except that single_file needs Python 3 (python3, or the program that
# the variable PYTHON names).
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)

usage() {
    sed -n '2,/^set/{/^set/d;s/^# \{0,1\}//p}' "$0" >&2
    exit 2
}

die() {
    echo "package.sh: $*" >&2
    exit 1
}

[ $# -eq 2 ] || [ $# -eq 3 ] || usage
way=$1
out=$2
url=${3:-}
case $way in
arduino | cmsis-pack | conan | esp-idf | meson | platformio | zephyr | single_file) ;;
*) usage ;;
esac
[ -n "$out" ] || usage
case $out in
-*) out=./$out ;;
esac

if [ -z "$url" ] && [ "$way" = cmsis-pack ]; then
    die "cmsis-pack needs a third argument: the URL of the folder that you publish it under"
fi
# The URL goes into XML by way of sed.
case $url in
*[!A-Za-z0-9:/.,_~%?=\#@+-]*)
    die "the URL $url holds a character that a URL does not, or one of ! \$ & ' ( ) * ;" ;;
esac
top=$out
first= # the topmost folder that does not exist
while [ ! -e "$top" ] && [ ! -L "$top" ]; do
    first=$top
    top=$(dirname "$top")
done
[ -d "$top" ] || die "$top is not a folder"
[ -n "$first" ] || [ -z "$(ls -A "$out")" ] ||
    die "$out is not empty: name another folder, or empty it first"
for part in LICENSE include src "port/$way"; do
    [ -e "$root/$part" ] || die "there is no $root/$part"
done
if [ "$way" = single_file ]; then
    python=${PYTHON:-python3}
    "$python" -c 'import sys; sys.exit(sys.version_info < (3, 6))' 2>/dev/null ||
        die "single_file needs Python 3.6 or later, and $python is not that." \
            "Install it, or name it: PYTHON=... sh port/package.sh ..."
fi

# The package is made in $work. Only when it is complete does anything appear in FOLDER.
work=$(mktemp -d "${TMPDIR:-/tmp}/rigcal.XXXXXX") || die "there is no temporary folder"
is_filling=
clean_up() {
    if [ -n "$is_filling" ] && [ -n "$first" ]; then
        rm -rf "$first"
    elif [ -n "$is_filling" ]; then
        for file in $(ls -A "$package"); do
            rm -rf "${out:?}/$file"
        done
    fi
    rm -rf "$work"
}
trap clean_up EXIT
trap 'exit 1' HUP INT TERM
package=$work/package
mkdir "$package"

part() {
    sed -n "s/^#define RIGCAL_VERSION_$1 *\([0-9]*\)$/\1/p" "$root/include/rigcal.h"
}
version=$(part MAJOR).$(part MINOR).$(part PATCH)

# list KIND FILE... prints a line of the manifest for each file of include/ or src/.
list() {
    kind=$1
    shift
    for path in "$@"; do
        name=${path#"$root"/}
        case $way in
        cmsis-pack) echo "        <file category=\"$kind\" name=\"$name\"/>" ;;
        meson) echo "    '$name'," ;;
        esac
    done
}

# Manifests hold @VERSION@, @URL@, and on lines of their own @HEADERS@ and @SOURCES@.
lay_out() {
    list header "$root"/include/*.h >"$work/headers"
    list sourceC "$root"/src/*.c >"$work/sources"

    cp "$root/LICENSE" "$package"
    (cd "$root/port/$way" && find . -type f ! -name '*.pyc') >"$work/files"
    while read -r file; do
        mkdir -p "$package/$(dirname "$file")"
        sed -e "/@HEADERS@/r $work/headers" -e "/@HEADERS@/d" \
            -e "/@SOURCES@/r $work/sources" -e "/@SOURCES@/d" \
            -e "s|@VERSION@|$version|g" -e "s|@URL@|$url|g" \
            "$root/port/$way/$file" >"$package/$file"
    done <"$work/files"

    case $way in
    arduino)
        # One folder of sources. There are no compiler options: a header has the choices.
        cp "$root"/include/*.h "$root"/src/*.[ch] "$package/src"
        sed '/^#ifdef RIGCAL_CONFIG_FILE/i\
#ifndef RIGCAL_CONFIG_FILE\
#define RIGCAL_CONFIG_FILE "rigcal_arduino.h"\
#endif' "$root/include/rigcal_config.h" >"$package/src/rigcal_config.h"
        ;;
    *)
        cp -R "$root/include" "$root/src" "$package"
        ;;
    esac
    case $way in
    conan)
        cp "$root/CMakeLists.txt" "$package"
        cp "$root/tests/consumers/main.c" "$package/test_package"
        ;;
    meson)
        cp "$root/tests/consumers/main.c" "$package"
        ;;
    esac
}

case $way in
single_file) "$python" "$root/port/single_file/amalgamate.py" "$package" >/dev/null ;;
*) lay_out ;;
esac

is_filling=1
mkdir -p "$out"
cp -R "$package/." "$out"
is_filling=
echo "rigcal $version for $way in $(cd "$out" && pwd)"
