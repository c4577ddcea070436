#!/bin/sh
# Calibrates the stereo pair from Python and from Rust.
#
#   sh examples/ffi/run.sh [python] [rust] [LIBDIR]
#
# With no language, both. Python needs NumPy, Rust needs rustc. LIBDIR holds
# librigcal.so: build/shared. PYTHON3: a Python 3 with NumPy, if not python3.
# RIGCAL_REAL=float: what the library was built with, if not double.
set -eu
cd "$(dirname "$0")/../.."
data=examples/data/opencv_stereo
reference=$data/reference_pairs.csv

languages=
libdir=build/shared
for argument in "$@"; do
    case $argument in
    python | rust) languages="$languages $argument" ;;
    *) libdir=$argument ;;
    esac
done

library=
for candidate in "$libdir/librigcal.so" "$libdir/librigcal.dylib"; do
    [ ! -e "$candidate" ] || library=$candidate
done
if [ -z "$library" ]; then
    echo "There is no shared librigcal in $libdir. To make build/shared:" \
        "cmake --preset shared && cmake --build --preset shared" >&2
    exit 1
fi
libdir=$(cd "$libdir" && pwd)

run_python() {
    python=${PYTHON3:-${PYTHON:-python3}}
    if ! "$python" -c "import numpy" 2>/dev/null; then
        echo "$python is no Python 3 with NumPy: install it, or name it in PYTHON3." >&2
        exit 1
    fi
    "$python" examples/ffi/python/stereo.py "$library" "$data" --check "$reference"
}

run_rust() {
    if ! command -v rustc >/dev/null; then
        echo "There is no rustc: install it." >&2
        exit 1
    fi
    work=$(mktemp -d)
    trap 'rm -rf "$work"' EXIT
    rustc --edition 2021 -D warnings -O -o "$work/stereo" -L "$libdir" \
        -C link-arg="-Wl,-rpath,$libdir" \
        ${RIGCAL_REAL:+--cfg "rigcal_$RIGCAL_REAL"} examples/ffi/rust/stereo.rs
    "$work/stereo" "$data" --check "$reference"
}

for language in ${languages:-python rust}; do
    "run_$language"
done
