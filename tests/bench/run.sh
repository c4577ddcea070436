#!/bin/sh
# The tables of BENCHMARKS.md and of port/cmsis_dsp, written by what makes them.
#
#   sh tests/bench/run.sh              all: hours
#   sh tests/bench/run.sh NAME...      these; --list prints the names
#   sh tests/bench/run.sh --check      the short forms, compared: a step of CI
#   sh tests/bench/run.sh --short      the short forms, written to tests/bench/short.md
set -eu
cd "$(dirname "$0")/../.."
. tests/support/packages.sh
want gcc gcc --version
want cmake cmake --version
want ninja-build ninja --version
install_missing
drop_moved_build build/gcc-double
mkdir -p build
if ! { cmake --preset gcc-double && cmake --build --preset gcc-double --target benches; } \
    >build/benches.log 2>&1; then
    tail -n 20 build/benches.log >&2
    exit 1
fi
python=$(find_python numpy scipy || find_python)
exec "$python" tests/bench/tables.py "$@"
