#!/bin/sh
# Calibrates the stereo pair from Python and from Rust.
#
#   sh examples/ffi/run.sh [LIBDIR]    LIBDIR holds librigcal.so: build/shared
#
# PYTHON3: a Python 3 with NumPy. RIGCAL_REAL=float: what the library was built
# with, if not double.
set -eu
cd "$(dirname "$0")/../.."
libdir=$(cd "${1:-build/shared}" && pwd)
data=examples/data/opencv_stereo
reference=$data/reference_pairs.csv

library=
for candidate in "$libdir/librigcal.so" "$libdir/librigcal.dylib"; do
    [ ! -e "$candidate" ] || library=$candidate
done
if [ -z "$library" ]; then
    echo "There is no shared librigcal in $libdir: cmake --preset shared" >&2
    exit 1
fi
if ! command -v rustc >/dev/null; then
    echo "There is no rustc." >&2
    exit 1
fi

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
rustc --edition 2021 -D warnings -O -o "$work/stereo" -L "$libdir" \
    -C link-arg="-Wl,-rpath,$libdir" \
    ${RIGCAL_REAL:+--cfg "rigcal_$RIGCAL_REAL"} examples/ffi/rust/stereo.rs

"${PYTHON3:-${PYTHON:-python3}}" examples/ffi/python/stereo.py "$library" \
    "$data" --check "$reference"
"$work/stereo" "$data" --check "$reference"
