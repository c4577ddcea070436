#!/bin/sh
# The documents: every snippet runs, the site builds without a warning, its pages are looked at.
#
#   sh port/python/docs/run.sh [FOLDER]     works in FOLDER, build/docs
set -eu
cd "$(dirname "$0")/../../.."

here=port/python/docs
mkdir -p "${1:-build/docs}"
out=$(cd "${1:-build/docs}" && pwd)
export MPLBACKEND=agg
. port/python/tests/venv.sh
make_venv "$out" $here/requirements.txt
wheel=$(sh port/python/tests/wheel.sh build/python)
pip_install "$wheel"
pip_install --force-reinstall --no-deps "$wheel"

PYTHON=$bin/python sh $here/build.sh "$out"
cd $here
RIGCAL_DOCS=$out/html "$bin/pytest" -q -p no:cacheprovider .
