#Runs cppcheck once for double and once for float. If it may mix both configurations, it
# reports overruns that neither has.
set -eu
cd "$(dirname "$0")/../.."

# unusedFunction is not asked for: a library's functions are used by others.
# variableScope is not either: a function's work arrays stand at its head.
# Nor are some that cppcheck 2.10 gets wrong: it does not see that N and D of
# begin_direction() are parts of *e, that conics() writes C0 of find_lines() through C, that
# rc_vec3_copy() writes a row of a projection, nor that a struct's initialiser keeps a pointer to
# the arrays of examples/rig.c. It takes a pointer into the caller's memory to work in for
# one to a local variable (objectIndex).
run() {
    cppcheck --quiet --std=c99 --language=c --inline-suppr --error-exitcode=1 \
        --enable=warning,style,performance,portability \
        --suppress=missingIncludeSystem --suppress=variableScope \
        --suppress=uninitvar:src/rigcal_lens.c \
        --suppress=uninitvar:src/rigcal_agree.c \
        --suppress=uninitvar:src/rigcal_p3p.c \
        --suppress=ctuuninitvar:src/rigcal_lens.c \
        --suppress=objectIndex \
        --suppress=unreadVariable:examples/rig.c \
        --suppress=unassignedVariable:examples/rig.c \
        --template='{file}:{line}: {id}: {message}' \
        -Iinclude -Isrc -Iexamples -DRIGCAL_BUILD -D__GNUC__ "$@" \
        src examples/*.c examples/firmware/*.c
}

run -URIGCAL_USE_FLOAT -URIGCAL_CONFIG_FILE -U_WIN32 -URIGCAL_SHARED \
    examples/paper/*.c
run -DRIGCAL_USE_FLOAT=1 -URIGCAL_CONFIG_FILE -U_WIN32 -URIGCAL_SHARED
echo "nothing found, double and float"
