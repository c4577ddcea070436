#!/bin/sh
# A copy of the project with an old build/ must work like a fresh one. CMake refuses the old
# cache, so the scripts make the folder again. The original must not change.
#
#   sh tests/regression/copied_checkout.sh FOLDER
set -eu
out=$(cd "$1" && pwd)

mkdir "$out/first"
tar -cf - --exclude=./build --exclude=./.git . | tar -xf - -C "$out/first"
# Two builds; none needs to be fast.
sed -i 's/"CMAKE_BUILD_TYPE": "Release"/"CMAKE_BUILD_TYPE": "Debug"/' \
    "$out/first/CMakePresets.json"
sh "$out/first/examples/run.sh" >"$out/first.txt" 2>&1 || { cat "$out/first.txt"; exit 1; }
# A file that must stay when it is built again in the same place.
echo kept >"$out/first/build/release/kept"
sh "$out/first/examples/run.sh" >"$out/first.txt" 2>&1 || { cat "$out/first.txt"; exit 1; }
[ -e "$out/first/build/release/kept" ] ||
    { echo "copied_checkout: a build in its own place was thrown away"; exit 1; }

cp -R "$out/first" "$out/second"
cp "$out/first/build/release/CMakeCache.txt" "$out/before.txt"
# The copy must build its own sources.
sed 's/\(RIGCAL_VERSION_PATCH\) [0-9]*$/\1 77/' "$out/first/include/rigcal.h" \
    >"$out/second/include/rigcal.h"
second=$out/second
if ! sh "$second/examples/run.sh" >"$out/second.txt" 2>&1; then
    echo "copied_checkout: examples/run.sh fails in $second:"
    cat "$out/second.txt"
    exit 1
fi
grep -q "^CMAKE_HOME_DIRECTORY:INTERNAL=$second$" "$second/build/release/CMakeCache.txt" ||
    { echo "copied_checkout: $second is built of other sources"; exit 1; }
version=$("$second/build/release/rigcal" --version)
case $version in
*.77*) ;;
*) echo "copied_checkout: the copy's program is of \"$version\""; exit 1 ;;
esac
cmp "$out/before.txt" "$out/first/build/release/CMakeCache.txt"

# Moved: its old place is no longer there.
mv "$second" "$out/third"
(cd "$out/third" && . tests/support/packages.sh && drop_moved_build build/release >/dev/null)
[ ! -e "$out/third/build/release" ] ||
    { echo "copied_checkout: the build of a moved copy is kept"; exit 1; }
echo "a copy and a moved copy are made anew, the original as before"
