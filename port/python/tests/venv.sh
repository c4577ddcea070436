# Sourced by the scripts that need Python tools in fixed versions.
#
#   make_venv FOLDER REQUIREMENTS   makes FOLDER/venv with the tools of the file, and sets
#                                   `bin`. It is kept while the file is the same.
#   pip_install WORD...             installs with the pip of that venv
#
# pip does not compile the tools: Python compiles what is imported, into FOLDER/pycache, which
# is not among the sources.

pip_install() {
    "$bin/pip" -q install --no-compile "$@"
}

make_venv() {
    export PYTHONPYCACHEPREFIX="$1/pycache" PIP_DISABLE_PIP_VERSION_CHECK=1
    bin=$1/venv/bin
    if ! cmp -s "$2" "$1/requirements.txt" || ! [ -x "$bin/pip" ]; then
        rm -rf "${1:?}/venv"
        /usr/bin/python3 -m venv "$1/venv"
        pip_install -r "$2"
        cp "$2" "$1/requirements.txt"
    fi
}
