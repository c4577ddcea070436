#!/bin/sh
# sh tests/run.sh STEP asks apt for the packages that this step needs, and for no others.
# All steps together ask for every package that some step needs.
#
#   sh tests/regression/step_packages.sh FOLDER
set -eu
out=$(cd "$1" && pwd)
bad=0

# A machine without tools, and an apt-get that prints what it was asked for.
mkdir "$out/bin"
for tool in sh sed awk tr sort id mktemp tail rm cat env dirname grep; do
    ln -s "$(command -v $tool)" "$out/bin/$tool"
done
cat >"$out/bin/apt-get" <<'EOF'
#!/bin/sh
case " $* " in
*" install "*) echo "$*" | sed 's/.* install //' | tr ' ' '\n' >"$ASKED"; exit 1 ;;
esac
EOF
printf '#!/bin/sh\nexec "$@"\n' >"$out/bin/sudo"
chmod +x "$out/bin/apt-get" "$out/bin/sudo"

export ASKED="$out/asked.txt"
# Prints the packages asked for, in one line. Whether Python and headers are missing is
# seen from files, not from PATH, so they depend on the machine.
asked() {
    : >"$ASKED"
    PATH=$out/bin HOME=$out XDG_CACHE_HOME=$out sh tests/run.sh "$@" \
        >"$out/said.txt" 2>&1 || true
    sed -n 's/^beside the first steps: //p' "$out/said.txt" | tr ' ' '\n' >>"$ASKED"
    grep -vE '^(python3|libc6-dev)' "$ASKED" | sort -u | tr '\n' ' ' | sed 's/ $//'
}

expect() {
    step=$1
    shift
    # shellcheck disable=SC2086 -- one step or more
    found=$(asked $step)
    if [ "$found" != "$*" ]; then
        echo "step_packages: $step asks for \"$found\", not for \"$*\""
        bad=1
    fi
}
arm="gcc-arm-none-eabi picolibc-arm-none-eabi qemu-system-arm"
expect layers gcc
expect manifests ""
expect header clang g++ gcc
# shellcheck disable=SC2086 -- several packages
expect cross $arm
expect gcc-double cmake gcc ninja-build xz-utils
expect cppcheck cppcheck
expect ffi cmake gcc ninja-build rustc
# shellcheck disable=SC2086 -- several packages
expect "cppcheck cross" cppcheck $arm
grep -qx "beside the first steps: $arm" "$out/said.txt" || {
    echo "step_packages: these are not installed beside the first step: $arm"
    bad=1
}
expect mips cmake gcc-mips-linux-gnu ninja-build qemu-user xz-utils

# Each step by itself, and all steps.
PATH=$out/bin sh tests/run.sh "?" 2>"$out/known.txt" && exit 1
known=$(sed -n 's/.*The steps are: //p' "$out/known.txt")
count=0
: >"$out/union.txt"
for step in $known; do
    case $step in
    shell | words | layout | manifests | vectors) continue ;; # these would run on this
                                                              # machine
    esac
    found=$(asked "$step")
    if [ -z "$found" ]; then
        echo "step_packages: $step asks for nothing, and says:"
        cat "$out/said.txt"
        bad=1
    fi
    echo "$found" | tr ' ' '\n' >>"$out/union.txt"
    count=$((count + 1))
done
union=$(grep . "$out/union.txt" | sort -u | tr '\n' ' ' | sed 's/ $//')
all=$(asked)
if [ "$union" != "$all" ] || [ $count -lt 30 ]; then
    echo "step_packages: all $count steps ask for \"$all\", one by one for \"$union\""
    bad=1
fi

[ $bad -eq 0 ] || exit 1
echo "$count steps, $(echo "$all" | wc -w) packages: each step asks for its own"
