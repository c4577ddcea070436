#!/bin/sh
# Makes the numbers, the figures and the tables of this folder, from nothing:
# installs a compiler, CMake, Ninja, NumPy and matplotlib if they are missing.
# Takes some three minutes.
set -eu
cd "$(dirname "$0")/../.."
. tests/support/packages.sh

want gcc cc --version
want libc6-dev test -e /usr/include/stdio.h
want cmake cmake --version
want ninja-build ninja --version
find_python numpy matplotlib >/dev/null ||
    missing="$missing python3 python3-numpy python3-matplotlib"
install_missing
PYTHON=$(find_python numpy matplotlib) || {
    echo "There is no Python 3 with numpy and matplotlib." >&2
    exit 1
}

mkdir -p build/logs
log=build/logs/paper.log
drop_moved_build build/release
if ! { cmake --preset release && cmake --build --preset release; } \
        >"$log" 2>&1; then
    tail -n 30 "$log" >&2
    echo "The build failed; all of its output is in $log." >&2
    exit 1
fi

here=examples/paper
build/release/rigcal_paper "$here/data"
"$PYTHON" "$here/draw.py" "$here/data" "$here/figures"
"$PYTHON" "$here/claims.py" "$here/data" "$here/README.md"
