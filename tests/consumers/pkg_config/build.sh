#!/bin/sh
# build.sh OUTPUT [--static]: one compiler line, flags from pkg-config.
set -eu
here=$(dirname "$0")
output=$1
shift
# shellcheck disable=SC2046 -- words
eval cc "$here/../main.c" -o "$output" $(pkg-config "$@" --cflags --libs rigcal)
