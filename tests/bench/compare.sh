#!/bin/sh
# Poses of the float build beside those of the double build, on the same scenes: a Markdown
# table of BENCHMARKS.md. Build the benches of the presets gcc-double and gcc-float first.
#
#   sh tests/bench/compare.sh [SCENES]
#
# SCENES a line (default 1000), with 0.1 px noise. What goes wrong is on stderr.
set -eu
cd "$(dirname "$0")/../.."
scenes=${1:-1000}
build/gcc-double/tests/bench_pose answers "$scenes" 0.1 |
    build/gcc-float/tests/bench_pose compare "$scenes" 0.1
