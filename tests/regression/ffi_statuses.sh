#!/bin/sh
# The programs of examples/ffi go on after a positive status and print its caveat, end after
# a negative one, and examples/ffi/run.sh needs the tools of the language asked for, no more.
#
#   sh tests/regression/ffi_statuses.sh FOLDER
set -eu
out=$(cd "$1" && pwd)
. tests/support/packages.sh
PYTHON=$(find_python numpy) || { echo "ffi_statuses: there is no Python 3 with NumPy"; exit 1; }
bad=0
count=0

complain() {
    echo "ffi_statuses: $*"
    cat "$out/stdout.txt" "$out/stderr.txt"
    bad=1
}

library=$PWD/build/shared
drop_moved_build "$library"
cmake --preset shared >"$out/build.txt" 2>&1 &&
    cmake --build --preset shared >>"$out/build.txt" 2>&1 || { cat "$out/build.txt"; exit 1; }
rustc --edition 2021 -D warnings -O -o "$out/stereo" -L "$library" \
    -C link-arg="-Wl,-rpath,$library" examples/ffi/rust/stereo.rs

# Changes the data by awk: $1 is the name of the folder, $2 the program.
data() {
    mkdir "$out/$1"
    cp examples/data/opencv_stereo/cameras.csv "$out/$1"
    awk -F, -v OFS=, "$2" examples/data/opencv_stereo/observations.csv \
        >"$out/$1/observations.csv"
}
# frame,camera,point,X,Y,Z,u,v
# Four corners of one square of the board, which leave two poses.
data four '$1 == "12" && $2 == "left" && $3 !~ /^(0|1|9|10)$/ {next} {print}'
data few '$1 == "01" && $2 == "left" && $3 > 1 {next} {print}'
data apart '$2 == "right" {$1 = "R" $1} {print}'

for language in python rust; do
    run() {
        count=$((count + 1))
        if [ $language = python ]; then
            "$PYTHON" examples/ffi/python/stereo.py "$library/librigcal.so" "$@"
        else
            "$out/stereo" "$@"
        fi >"$out/stdout.txt" 2>"$out/stderr.txt"
    }
    # fails DATA TEXT: the program must end and say why
    fails() {
        if run "$out/$1"; then
            complain "$language accepts the data $1"
        elif ! grep -q "$2" "$out/stderr.txt"; then
            complain "$language refuses the data $1 without \"$2\""
        fi
    }
    run "$out/four" --check examples/data/opencv_stereo/reference_pairs.csv ||
        complain "$language ends at a caveat"
    grep -q "caveat: camera left, frame 12: " "$out/stderr.txt" ||
        complain "$language prints no caveat"
    grep -q "^$language: *right from left: baseline" "$out/stdout.txt" ||
        complain "$language prints no result after a caveat"
    fails few "camera left, frame 01: "
    fails apart "never saw the target in one place"
done

# A PATH without the tools of the other language.
mkdir "$out/bin"
for tool in sh dirname mktemp rm cc ld ar; do
    ln -s "$(command -v $tool)" "$out/bin/$tool"
done
count=$((count + 2))
PATH=$out/bin PYTHON3=$PYTHON \
    sh examples/ffi/run.sh python "$library" >"$out/stdout.txt" 2>"$out/stderr.txt" ||
    complain "run.sh python fails without rustc"
PYTHON3=$out/none sh examples/ffi/run.sh rust "$library" \
    >"$out/stdout.txt" 2>"$out/stderr.txt" || complain "run.sh rust fails without Python"

[ $bad -eq 0 ] || exit 1
echo "$count runs of the programs of examples/ffi"
