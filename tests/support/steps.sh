# Sourced by the shell of each step that tests/run.sh starts, at the project's root.
#
#   preset_build PRESET [TARGET]
#                         builds in build/PRESET, all or the target alone
#   preset PRESET         builds, and runs every test
#   clang_library PRESET  builds the library of PRESET by clang, and tests that it counts as
#                         gcc's does. In double the unit tests of gcc-double run with it. In
#                         float the step single-file runs them with what clang makes of one
#                         source; here clang compiles them for its warnings
#   cli PRESET            builds, and runs the tests of the command line
#   regressions           runs every tests/regression/*.sh
#
# How many jobs run at a time is in CMAKE_BUILD_PARALLEL_LEVEL and CTEST_PARALLEL_LEVEL.

set -u
. tests/support/packages.sh

preset_build() {
    drop_moved_build "build/$1"
    cmake --preset "$1" && cmake --build --preset "$1" ${2:+--target "$2"}
}

preset() {
    preset_build "$1" && ctest --preset "$1"
}

clang_library() {
    preset_build "$1" rigcal &&
        case $1 in
        *float) warnings_of "$1" ;;
        *) sh tests/ways/relink.sh build/gcc-double "build/$1/relinked" clang \
            "build/$1/librigcal.a" ;;
        esac &&
        cmake --build --preset "$1" --target gate test_bounds &&
        ctest --preset "$1" -R '^(gate|bounds)$'
}

# Compiles what the preset would compile besides the library, with the same options.
warnings_of() {
    sed -n 's/^ *"command": "\(.*\)",*$/\1/p' "build/$1/compile_commands.json" |
        grep -v ' -c [^ ]*/src/' |
        sed 's/\\"/"/g; s/\\\\/\\/g; s/ -o [^ ]* / -fsyntax-only /' >"build/$1/warnings.sh"
    (cd "build/$1" && sh -e warnings.sh) &&
        echo "no warning in $(wc -l <"build/$1/warnings.sh") files"
}

cli() {
    preset_build "$1" && RIGCAL_BIN=build/$1/rigcal $PYTHON tests/cli/test_cli.py
}

# Each script gets an empty folder of its own.
regressions() {
    bad=
    count=0
    for script in tests/regression/*.sh; do
        [ -e "$script" ] || continue
        name=$(basename "$script" .sh)
        work=build/regression/$name
        rm -rf "$work"
        mkdir -p "$work"
        echo "== $name"
        sh "$script" "$work" || bad="$bad $name"
        count=$((count + 1))
    done
    if [ -n "$bad" ]; then
        echo "regressions:$bad"
        return 1
    fi
    echo "$count scripts"
}
