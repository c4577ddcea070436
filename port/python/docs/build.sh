#!/bin/sh
# Builds the site. A warning is an error.
#
#   sh port/python/docs/build.sh [FOLDER]     works in FOLDER, build/docs: FOLDER/html
#
# PYTHON: a Python with requirements.txt and rigcal, if not python3.
set -eu
cd "$(dirname "$0")/../../.."

mkdir -p "${1:-build/docs}"
out=$(cd "${1:-build/docs}" && pwd)
python=${PYTHON:-python3}
rm -rf "${out:?}/source" "${out:?}/html"
mkdir "$out/source"
here=port/python/docs
cp -R $here/*.md $here/conf.py $here/howto $here/reference $here/_static "$out/source"
cp port/python/FORMATS.md "$out/source/formats.md"
cp port/python/DETECT.md "$out/source/images.md"
"$python" -c 'import rigcal.command; rigcal.command.main(["--help"])' >"$out/source/help.txt"
"$python" $here/drawings.py "$out/source"
"$python" -m sphinx -q -W --keep-going -E -d "$out/doctrees" -b html "$out/source" "$out/html"
echo "$(find "$out/html" -name '*.html' | wc -l) pages: $out/html/index.html"
