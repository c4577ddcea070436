# Sourced by tests/run.sh and examples/run.sh: installs what is missing, by apt.
#
#   want PACKAGE COMMAND...   PACKAGE is missing unless COMMAND succeeds
#   install_missing           installs what was wanted and missing, if anything

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
    # A broken third-party source fails the update; the install then decides.
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
