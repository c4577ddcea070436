#!/bin/sh
# The fleet of make_sample.py by a loop and on a Dask cluster, one worker of which is killed.
#
#   sh examples/fleet/run.sh [FOLDER]     works in FOLDER, build/fleet
set -eu
cd "$(dirname "$0")/../.."

here=examples/fleet
mkdir -p "${1:-build/fleet}"
out=$(cd "${1:-build/fleet}" && pwd)
. port/python/tests/venv.sh
make_venv "$out" $here/requirements.txt
wheel=$(sh port/python/tests/wheel.sh build/python)
pip_install "$wheel"
pip_install --force-reinstall --no-deps "$wheel"

"$bin/ruff" check --no-cache --config port/python/pyproject.toml $here
"$bin/ruff" format --no-cache --check --config port/python/pyproject.toml $here
cd $here
"$bin/pytest" -q -p no:cacheprovider test_fleet.py
