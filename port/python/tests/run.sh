#!/bin/sh
# The Python package, from nothing: built, installed, its types, style and tests.
#
#   sh port/python/tests/run.sh [FOLDER]     works in FOLDER, build/python
set -eu
cd "$(dirname "$0")/../../.."

mkdir -p "${1:-build/python}"
out=$(cd "${1:-build/python}" && pwd)
here=port/python
export HYPOTHESIS_STORAGE_DIRECTORY="$out/hypothesis"
. port/python/tests/venv.sh
make_venv "$out" $here/tests/requirements.txt

# The wheel from a checkout. It is built only once for the same sources and tools.
rm -rf "${out:?}/wheel" "${out:?}/sdist" "${out:?}/unpacked"
"$bin/pip" -q wheel --no-build-isolation --no-deps \
    --config-settings=build-dir="$out/cmake" -w "$out/wheel" ./$here
wheel=$(echo "$out"/wheel/rigcal-*.whl)
size=$(wc -c <"$wheel")
if [ "$size" -gt 409600 ]; then
    echo "$wheel has $size bytes, more than 400 KB"
    exit 1
fi
pip_install --force-reinstall --no-deps "$wheel"

# The sdist must build by itself: it is unpacked where no checkout is above it.
"$bin/python" -m build -q --no-isolation --sdist -o "$out/sdist" $here
alone=$(mktemp -d)
trap 'rm -rf "$alone"' EXIT
tar -xzf "$out"/sdist/rigcal-*.tar.gz -C "$alone"
"$bin/pip" -q wheel --no-build-isolation --no-deps \
    --config-settings=cmake.build-type=Debug --config-settings=install.strip=false \
    -w "$alone/wheel" "$alone"/rigcal-*/
"$bin/python" - "$wheel" "$alone"/wheel/rigcal-*.whl <<'END'
import sys, zipfile
names = [sorted(zipfile.ZipFile(path).namelist()) for path in sys.argv[1:]]
if names[0] != names[1]:
    sys.exit(f"the wheels of checkout and sdist differ: {set(names[0]) ^ set(names[1])}")
END

cd $here
"$bin/python" make_names.py --check
"$bin/ruff" check --no-cache
"$bin/ruff" format --no-cache --check
"$bin/mypy" --cache-dir "$out/mypy"
export COVERAGE_FILE="$out/coverage"
"$bin/coverage" run "$bin/pytest" -q -p no:cacheprovider
"$bin/coverage" report --skip-covered --fail-under=95
echo "$(basename "$wheel") of $size bytes: types, style, tests"
