#!/bin/sh
# Everything that a release publishes, in one folder: the packages, a list of what they consist
# of, and checksums. Two runs from one commit make the same bytes.
#
#   sh port/release.sh FOLDER [URL]
#
# FOLDER must not exist. URL, of the folder that you publish under, is for cmsis-pack; without
# it that package is left out. Needs git, tar, gzip, Python 3.
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)

die() {
    echo "release.sh: $*" >&2
    exit 1
}

[ $# -eq 1 ] || [ $# -eq 2 ] || die "usage: sh port/release.sh FOLDER [URL]"
case $1 in
/*) out=$1 ;;
*) out=$PWD/$1 ;;
esac
url=${2:-}
[ ! -e "$out" ] || die "$1 exists: name a new folder"
python=${PYTHON:-python3}

# Time stamps in the archives: the time of the commit or, without git, the time that the
# caller states.
if [ -z "${SOURCE_DATE_EPOCH:-}" ]; then
    SOURCE_DATE_EPOCH=$(git -C "$root" log -1 --format=%ct) ||
        die "there is no commit here: give its time in seconds as SOURCE_DATE_EPOCH"
fi
part() {
    sed -n "s/^#define RIGCAL_VERSION_$1 *\([0-9]*\)$/\1/p" "$root/include/rigcal.h"
}
version=$(part MAJOR).$(part MINOR).$(part PATCH)

work=$(mktemp -d "${TMPDIR:-/tmp}/rigcal.XXXXXX") || die "there is no temporary folder"
trap 'rm -rf "$work"' EXIT
trap 'exit 1' HUP INT TERM
made=$work/made
mkdir "$made"

archive() { # NAME, of a folder in $work
    (cd "$work" && find "$1" -exec chmod go-w,a+rX {} +)
    tar -C "$work" --sort=name --format=ustar --mtime="@$SOURCE_DATE_EPOCH" --owner=0 --group=0 \
        --numeric-owner -cf - "$1" | gzip -n -9 >"$made/$1.tar.gz"
}

for way in single_file arduino cmsis-pack conan esp-idf meson platformio zephyr; do
    [ "$way" != cmsis-pack ] || [ -n "$url" ] || continue
    name=rigcal-$version-$(echo "$way" | tr _ -)
    if [ "$way" = cmsis-pack ]; then
        sh "$root/port/package.sh" "$way" "$work/$name" "$url" >/dev/null
    else
        sh "$root/port/package.sh" "$way" "$work/$name" >/dev/null
    fi
    archive "$name"
done
"$python" "$root/port/sbom.py" "$SOURCE_DATE_EPOCH" >"$made/rigcal-$version.spdx.json"
(cd "$made" && sha256sum -- * >"$work/sums" && mv "$work/sums" SHA256SUMS)
mkdir -p "$(dirname "$out")"
mv "$made" "$out"
echo "rigcal $version: $(find "$out" -type f | wc -l) files in $1; sha256sum -c SHA256SUMS checks them"
