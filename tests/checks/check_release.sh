#!/bin/sh
# Checks that a release has the same bytes wherever and whenever it is made, and that its
# lists are right.
#
#   sh tests/checks/check_release.sh FOLDER    works in FOLDER, which is made anew
set -eu
cd "$(dirname "$0")/../.."
rm -rf "$1"
mkdir -p "$1"
out=$(cd "$1" && pwd)
export SOURCE_DATE_EPOCH=1700000000

# Copies the files of a release into folders whose names have different lengths.
for copy in here elsewhere/much/deeper; do
    mkdir -p "$out/$copy"
    cp -R CMakeLists.txt CMakePresets.json LICENSE README.md include src port examples "$out/$copy"
    mkdir -p "$out/$copy/tests"
    cp -R tests/consumers "$out/$copy/tests"
    (cd "$out/$copy" && sh port/release.sh made https://example.org/rigcal) >"$out/log"
    cmake -S "$out/$copy" -B "$out/$copy/build" -G Ninja -DCMAKE_BUILD_TYPE=Release \
        -DCMAKE_C_FLAGS_RELEASE=-O1 >>"$out/log"
    cmake --build "$out/$copy/build" --target rigcal rigcal_cli >>"$out/log" || { cat "$out/log"; exit 1; }
done
one=$out/here
other=$out/elsewhere/much/deeper
diff -r "$one/made" "$other/made"
cmp "$one/build/librigcal.a" "$other/build/librigcal.a"
cmp "$one/build/rigcal" "$other/build/rigcal"
(cd "$one/made" && sha256sum --quiet -c SHA256SUMS)
python3 - "$one/made" <<'END'
import hashlib, json, pathlib, sys
bill = json.loads(next(pathlib.Path(sys.argv[1]).glob("*.spdx.json")).read_text())
listed = {file["fileName"] for file in bill["files"]}
there = {"./" + path.as_posix() for folder in ("include", "src") for path in pathlib.Path(folder).iterdir()}
assert listed == there, listed ^ there
for file in bill["files"]:
    content = pathlib.Path(file["fileName"]).read_bytes()
    sums = {c["algorithm"]: c["checksumValue"] for c in file["checksums"]}
    assert sums == {"SHA1": hashlib.sha1(content).hexdigest(), "SHA256": hashlib.sha256(content).hexdigest()}, file
code = hashlib.sha1("".join(sorted(hashlib.sha1(pathlib.Path(f).read_bytes()).hexdigest() for f in there)).encode())
package, = bill["packages"]
assert package["packageVerificationCode"]["packageVerificationCodeValue"] == code.hexdigest()
END
echo "release: $(find "$one/made" -type f | wc -l) files, library and program, the same bytes in two folders"
