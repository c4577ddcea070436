#!/bin/sh
# port/package.sh needs Python only for the single file, says what is missing, and leaves
# nothing behind when it fails: neither a part of a package nor a temporary folder.
#
#   sh tests/regression/package_leaves_nothing.sh FOLDER
set -eu
unset PYTHON # which tests/run.sh exports, and would be found without PATH
out=$(cd "$1" && pwd)
bad=0
count=0

complain() {
    echo "package_leaves_nothing: $*"
    cat "$out/said.txt"
    bad=1
}

# A PATH with what a shell script may expect, but without Python.
mkdir "$out/bin" "$out/tmp"
for tool in sh sed mkdir cp rm ls cat find dirname basename mktemp; do
    ln -s "$(command -v $tool)" "$out/bin/$tool"
done
# A cp that fails at call number CP_FAILS, after half of its work.
mkdir "$out/failing"
cat >"$out/failing/cp" <<EOF
#!/bin/sh
echo >>"\$CP_CALLS"
"$(command -v cp)" "\$@" || exit 1
[ "\$(wc -l <"\$CP_CALLS")" -ne "\$CP_FAILS" ] || { echo "cp: no space left" >&2; exit 1; }
EOF
chmod +x "$out/failing/cp"

package() {
    count=$((count + 1))
    TMPDIR=$out/tmp PATH=$path sh port/package.sh "$@" >"$out/said.txt" 2>&1
}

# fails_cleanly MESSAGE ARGUMENT...: the message appears, and no file
fails_cleanly() {
    message=$1
    shift
    find "$out/there" | sort >"$out/before.txt"
    if package "$@"; then
        complain "$* does not fail"
    elif ! grep -qi -e "$message" "$out/said.txt"; then
        complain "$* fails without \"$message\":"
    fi
    find "$out/there" | sort >"$out/after.txt"
    diff "$out/before.txt" "$out/after.txt" || complain "$* leaves files behind"
    [ -z "$(ls -A "$out/tmp")" ] || complain "$* leaves $(ls "$out/tmp") behind"
}

path=$out/bin
mkdir "$out/there" "$out/there/empty" "$out/there/mine"
echo mine >"$out/there/mine/file"
for way in arduino cmsis-pack conan esp-idf meson platformio zephyr; do
    package $way "$out/made/$way" https://example.org/rigcal ||
        complain "$way cannot be made without Python"
    [ -e "$out/made/$way/LICENSE" ] || complain "$way has no LICENSE"
done
fails_cleanly "needs Python" single_file "$out/there/new"
fails_cleanly "needs Python" single_file "$out/there/empty"
fails_cleanly "not empty" arduino "$out/there/mine"
fails_cleanly "not a folder" arduino "$out/there/mine/file"
fails_cleanly "not a folder" arduino "$out/there/mine/file/folder"
fails_cleanly "the URL" cmsis-pack "$out/there/new"
fails_cleanly "character" cmsis-pack "$out/there/new" 'https://example.org/<rigcal>'
fails_cleanly "sh port/package.sh WAY FOLDER" wrong "$out/there/new"
[ "$(cat "$out/there/mine/file")" = mine ] || complain "a file of the user's was replaced"

# Each cp of a package fails once. The last one puts the package into its place.
export CP_CALLS="$out/calls.txt" CP_FAILS=0
path=$out/failing:$PATH
for way in arduino conan single_file; do
    : >"$CP_CALLS"
    CP_FAILS=0
    package $way "$out/whole/$way"
    calls=$(wc -l <"$CP_CALLS")
    [ "$calls" -ge 1 ] || complain "$way calls no cp"
    for n in $(seq "$calls"); do
        for folder in empty new some/new/folder; do
            : >"$CP_CALLS"
            CP_FAILS=$n
            fails_cleanly "no space left" $way "$out/there/$folder"
        done
    done
done

# The single file replaces only files that it made itself.
python=${PYTHON:-python3}
"$python" port/single_file/amalgamate.py "$out/single" >"$out/said.txt"
"$python" port/single_file/amalgamate.py "$out/single" >"$out/said.txt" 2>&1 ||
    complain "the single file is not made anew"
echo '/* mine */' >"$out/single/rigcal.h"
rm "$out/single/rigcal.c"
if "$python" port/single_file/amalgamate.py "$out/single" >"$out/said.txt" 2>&1; then
    complain "the single file replaces a header of the user's"
fi
[ ! -e "$out/single/rigcal.c" ] || complain "half of the single file is left"

[ $bad -eq 0 ] || exit 1
echo "$count packages: whole, or nothing of them"
