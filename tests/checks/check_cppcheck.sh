#!/bin/sh
# cppcheck, once for double and once for float: when left to mix the two it
# reports overruns that neither has.
set -eu
cd "$(dirname "$0")/../.."

# unusedFunction is not asked for: a library's functions are used by others.
# variableScope is not either: a function's work arrays stand at its head.
run() {
    cppcheck --quiet --std=c99 --language=c --inline-suppr --error-exitcode=1 \
        --enable=warning,style,performance,portability \
        --suppress=missingIncludeSystem --suppress=variableScope \
        --template='{file}:{line}: {id}: {message}' \
        -Iinclude -Isrc -Iexamples -DRIGCAL_BUILD -D__GNUC__ "$@" \
        src examples/*.c examples/firmware/*.c
}

run -URIGCAL_USE_FLOAT -URIGCAL_CONFIG_FILE -U_WIN32 -URIGCAL_SHARED \
    examples/paper/*.c
run -DRIGCAL_USE_FLOAT=1 -URIGCAL_CONFIG_FILE -U_WIN32 -URIGCAL_SHARED
echo "nothing found, double and float"
