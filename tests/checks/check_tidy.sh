#!/bin/sh
# clang-tidy with the checks of .clang-tidy, of the library in double and in float, with
# its assertions, and of the examples.
set -eu
cd "$(dirname "$0")/../.."

jobs=$(nproc 2>/dev/null || echo 2)

# One process for each file. xargs fails if one of them fails.
tidy() {
    files=$1
    shift
    # shellcheck disable=SC2086 -- a list of files
    printf '%s\n' $files | xargs -P "$jobs" -I FILE clang-tidy --quiet FILE -- \
        -std=c99 -Iinclude -Iexamples "$@"
}

tidy "$(echo src/*.c)" -DRIGCAL_BUILD -DRIGCAL_ASSERTS=1
tidy "$(echo src/*.c)" -DRIGCAL_BUILD -DRIGCAL_USE_FLOAT=1
tidy "$(echo examples/*.c examples/firmware/*.c)"
echo "nothing found in $(echo src/*.c examples/*.c examples/firmware/*.c | wc -w) files"
