# Sourced by tests/run.sh, examples/run.sh and others.
#
#   want PACKAGE COMMAND...   PACKAGE is missing unless COMMAND succeeds
#   install_missing           installs by apt what was wanted and missing, if anything
#   find_python MODULE...     prints a Python 3 that has these modules
#   commit_of PATH...         prints the commit, and whether the paths differ from it; or that
#                             it is not known, as in a release's archive
#   drop_moved_build FOLDER   removes what CMake built while it lay in another place

missing=

want() {
    package=$1
    shift
    "$@" >/dev/null 2>&1 || missing="$missing $package"
}

as_root() {
    if [ "$(id -u)" -eq 0 ]; then
        "$@"
    else
        sudo "$@"
    fi
}

install_missing() {
    [ -n "$missing" ] || return 0
    if ! command -v apt-get >/dev/null; then
        echo "Please install first:$missing" >&2
        return 1
    fi
    if [ "$(id -u)" -ne 0 ] && ! command -v sudo >/dev/null; then
        echo "Installing needs root or sudo:$missing" >&2
        return 1
    fi
    echo "installing:$missing"
    log=$(mktemp)
    # If a third-party source is broken the update fails. The installation then decides.
    as_root apt-get -q update >"$log" 2>&1 || true
    # shellcheck disable=SC2086 -- a list of packages
    if ! as_root env DEBIAN_FRONTEND=noninteractive apt-get -q -y \
            --no-install-recommends install $missing >>"$log" 2>&1 </dev/null
    then
        tail -n 20 "$log" >&2
        rm -f "$log"
        echo "apt could not install:$missing" >&2
        return 1
    fi
    rm -f "$log"
    missing=
}

# Prints the first Python 3 that can import all the modules named.
find_python() {
    for candidate in "${PYTHON:-python3}" /usr/bin/python3; do
        for module in "$@" sys; do
            "$candidate" -c "import $module" >/dev/null 2>&1 || continue 2
        done
        command -v "$candidate"
        return 0
    done
    return 1
}

commit_of() {
    commit=$(git rev-parse --short HEAD 2>/dev/null) || { echo "not known"; return 0; }
    git diff --quiet HEAD -- "$@" || commit="$commit, changed"
    echo "$commit"
}

# CMake refuses a build folder that was copied or moved together with its sources.
drop_moved_build() {
    [ -f "$1/CMakeCache.txt" ] || return 0
    made_in=$(sed -n 's/^CMAKE_CACHEFILE_DIR:INTERNAL=//p' "$1/CMakeCache.txt")
    made_of=$(sed -n 's/^CMAKE_HOME_DIRECTORY:INTERNAL=//p' "$1/CMakeCache.txt")
    if ! [ "$made_in" -ef "$1" ] || ! [ "$made_of" -ef . ]; then
        echo "$1 was built in another place, $made_in: it is made anew"
        rm -rf "${1:?}"
    fi
}
