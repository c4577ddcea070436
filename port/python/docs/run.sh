#!/bin/sh
# The documents: every snippet runs, the site builds without a warning, its pages are looked at.
#
#   sh port/python/docs/run.sh [FOLDER]     works in FOLDER, build/docs
set -eu
cd "$(dirname "$0")/../../.."

here=port/python/docs
mkdir -p "${1:-build/docs}"
out=$(cd "${1:-build/docs}" && pwd)
# pip does not compile the tools: Python compiles what is imported, into a folder that is not
# among the sources.
export PYTHONPYCACHEPREFIX="$out/pycache" PIP_DISABLE_PIP_VERSION_CHECK=1 MPLBACKEND=agg
wheel=$(sh port/python/tests/wheel.sh build/python)
bin=$out/venv/bin
if ! cmp -s $here/requirements.txt "$out/requirements.txt" || ! [ -x "$bin/sphinx-build" ]; then
    rm -rf "${out:?}/venv"
    /usr/bin/python3 -m venv "$out/venv"
    "$bin/pip" -q install --no-compile -r $here/requirements.txt
    cp $here/requirements.txt "$out"
fi
"$bin/pip" -q install --no-compile "$wheel"
"$bin/pip" -q install --no-compile --force-reinstall --no-deps "$wheel"

PYTHON=$bin/python sh $here/build.sh "$out"
cd $here
RIGCAL_DOCS=$out/html "$bin/pytest" -q -p no:cacheprovider .
