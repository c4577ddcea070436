#!/bin/sh
# The fleet of make_sample.py by a loop and on a Dask cluster, one worker of which is killed.
#
#   sh examples/fleet/run.sh [FOLDER]     works in FOLDER, build/fleet
set -eu
cd "$(dirname "$0")/../.."

here=examples/fleet
mkdir -p "${1:-build/fleet}"
out=$(cd "${1:-build/fleet}" && pwd)
# pip does not compile the tools: Python compiles what is imported, into a folder that is not
# among the sources.
export PYTHONPYCACHEPREFIX="$out/pycache" PIP_DISABLE_PIP_VERSION_CHECK=1
wheel=$(sh port/python/tests/wheel.sh build/python)
bin=$out/venv/bin
if ! cmp -s $here/requirements.txt "$out/requirements.txt" || ! [ -x "$bin/ruff" ]; then
    rm -rf "${out:?}/venv"
    /usr/bin/python3 -m venv "$out/venv"
    "$bin/pip" -q install --no-compile -r $here/requirements.txt
    cp $here/requirements.txt "$out"
fi
"$bin/pip" -q install --no-compile "$wheel"
"$bin/pip" -q install --no-compile --force-reinstall --no-deps "$wheel"

"$bin/ruff" check --no-cache --config port/python/pyproject.toml $here
"$bin/ruff" format --no-cache --check --config port/python/pyproject.toml $here
cd $here
"$bin/pytest" -q -p no:cacheprovider test_fleet.py
