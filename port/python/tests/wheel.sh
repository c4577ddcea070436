#!/bin/sh
# Prints the path of the wheel of these sources: the one that the step python made, or a new
# one if the sources are newer.
#
#   sh port/python/tests/wheel.sh FOLDER     FOLDER is that of the step python, build/python
set -eu
cd "$(dirname "$0")/../../.."

mkdir -p "$1"
out=$(cd "$1" && pwd)
wheel=$(echo "$out"/wheel/rigcal-*.whl)
if ! [ -f "$wheel" ] || [ -n "$(find port/python/rigcal port/python/*.[cht]* src include \
        examples/*cli* CMakeLists.txt -newer "$wheel" ! -name '*.pyc' -type f | head -n 1)" ]
then
    rm -rf "${out:?}/wheel"
    [ -x "$out/pip/bin/pip" ] || /usr/bin/python3 -m venv "$out/pip"
    "$out/pip/bin/pip" -q wheel --no-deps --config-settings=build-dir="$out/cmake-alone" \
        -w "$out/wheel" ./port/python
    wheel=$(echo "$out"/wheel/rigcal-*.whl)
fi
echo "$wheel"
