#!/bin/sh
# Each package of port/package.sh, taken in by the tool it is for and built. Where
# that wants a vendor's SDK (ESP-IDF, Zephyr, an Arduino core), the little of it that
# the package calls stands in this folder, for the host. What is tried is the packages, not
# what an optimiser makes of them: -O0, if the tool lets us.
#
#   sh tests/ways/run.sh [FOLDER]     builds in FOLDER, build/ways
set -eu
cd "$(dirname "$0")/../.."

mkdir -p "${1:-build/ways}"
out=$(cd "${1:-build/ways}" && pwd)
rm -rf "${out:?}"/*
here=tests/ways
count=0

# The tools in fixed versions, kept in the user's cache for later runs.
tools=${XDG_CACHE_HOME:-${HOME:-$out}/.cache}/rigcal/ways
if ! cmp -s $here/requirements.txt "$tools/requirements.txt"; then
    rm -rf "$tools"
    /usr/bin/python3 -m venv "$tools"
    "$tools/bin/pip" -q --disable-pip-version-check install --no-compile -r $here/requirements.txt
    cp $here/requirements.txt "$tools"
fi
bin=$tools/bin
# The tools write nothing elsewhere.
export PYTHONPYCACHEPREFIX="$out/home/pycache"
export CONAN_HOME="$out/home/conan" PLATFORMIO_CORE_DIR="$out/home/platformio"
export PLATFORMIO_SETTING_ENABLE_TELEMETRY=no IDF_COMPONENT_CACHE_PATH="$out/home/idf"

for way in arduino cmsis-pack conan esp-idf meson platformio zephyr; do
    sh port/package.sh $way "$out/$way/rigcal" https://example.org/rigcal
done

# Runs a program and compares its output with $1.
check() {
    expected=$1
    shift
    said=$("$@" 2>&1) || { echo "ways: $1 failed: $said"; exit 1; }
    case $said in
    *"$expected"*) count=$((count + 1)) ;;
    *) echo "ways: $1 says \"$said\", not \"$expected\""; exit 1 ;;
    esac
}
double="rigcal_real of 8 bytes, with fisheyes"
float="rigcal_real of 4 bytes, with fisheyes"
other="rigcal_real of 8 bytes, without fisheyes"

# Arduino: its builder takes the library for the example, for this machine as a board.
board=$out/arduino/hardware/rigcal/host
mkdir -p "$board/cores/host" "$out/arduino/build"
cp $here/arduino/*.txt "$board"
cp $here/arduino/Arduino.h $here/arduino/main.cpp "$board/cores/host"
arduino-builder -compile -hardware "$out/arduino/hardware" -tools "$out/arduino/build" \
    -libraries "$out/arduino" -fqbn rigcal:host:pc -build-path "$out/arduino/build" \
    -warnings all "$out/arduino/rigcal/examples/Pose/Pose.ino"
check "-0.561 -0.443 0.838 m, to 0.01 px" "$out/arduino/build/Pose.ino.elf"
gcc -std=gnu11 -I"$out/arduino/rigcal/src" tests/consumers/main.c \
    "$out"/arduino/build/libraries/rigcal/*.o -lm -o "$out/arduino/program"
check "$float" "$out/arduino/program"

# CMSIS-Pack: compiles what the description lists for each variant, and nothing else.
for variant in float double; do
    /usr/bin/python3 $here/pdsc.py "$out/cmsis-pack/rigcal/rigcal.rigcal.pdsc" \
        $variant "$out/cmsis-pack/$variant.h" >"$out/cmsis-pack/$variant"
    # shellcheck disable=SC2046 -- a list of sources
    (cd "$out/cmsis-pack/rigcal" &&
        gcc -std=c99 -O0 -include "../$variant.h" -Iinclude $(cat ../$variant) \
            "$OLDPWD/tests/consumers/main.c" -lm -o ../program_$variant)
done
check "$double" "$out/cmsis-pack/program_double"
check "$float" "$out/cmsis-pack/program_float"

# Conan: create builds the package and runs its test.
"$bin/conan" profile detect
check "$double" "$bin/conan" create "$out/conan/rigcal" --no-remote -s build_type=Debug
check "$float" "$bin/conan" create "$out/conan/rigcal" --no-remote -s build_type=Debug \
    -o "rigcal/*:real=float" -o "rigcal/*:shared=True"

# ESP-IDF: the component manager reads and packs it. Kconfig chooses: once its defaults, once
# the other value of both settings.
(cd "$out/esp-idf/rigcal" && "$bin/compote" manifest lint)
"$bin/compote" component pack --project-dir "$out/esp-idf/rigcal" --name rigcal \
    --dest-dir "$out/esp-idf"
for build in float other; do
    choices=
    [ $build != other ] || choices="RIGCAL_USE_FLOAT=n RIGCAL_WITH_FISHEYE=n"
    # shellcheck disable=SC2046 -- several settings
    cmake -G Ninja -S $here/esp-idf -B "$out/esp-idf/$build" \
        -DPACKAGE="$out/esp-idf/rigcal" $("$bin/python" $here/kconfig.py \
            "$out/esp-idf/rigcal/Kconfig" $choices)
    cmake --build "$out/esp-idf/$build"
done
check "$float" "$out/esp-idf/float/consumer"
check "$other" "$out/esp-idf/other/consumer"

# Meson: as a project and as a subproject of another.
"$bin/meson" setup "$out/meson/build" "$out/meson/rigcal" --werror \
    -Dreal=float -Ddefault_library=shared
check "$float" "$bin/meson" test -C "$out/meson/build" --verbose
mkdir -p "$out/meson/app/subprojects"
cp tests/consumers/main.c $here/meson/meson.build "$out/meson/app"
cp -R "$out/meson/rigcal" "$out/meson/app/subprojects"
"$bin/meson" setup "$out/meson/app/build" "$out/meson/app"
"$bin/meson" compile -C "$out/meson/app/build"
check "$double" "$out/meson/app/build/app"

# PlatformIO: packed by its own tool, but without the licence field, because the tool would
# ask its registry for the list of licences. Then it is built as the manifest says.
mkdir "$out/platformio/unpacked"
cp -R "$out/platformio/rigcal" "$out/platformio/unlicensed"
sed -i '/"license"/d' "$out/platformio/unlicensed/library.json"
"$bin/pio" pkg pack "$out/platformio/unlicensed" -o "$out/platformio/rigcal.tar.gz"
tar -xzf "$out/platformio/rigcal.tar.gz" -C "$out/platformio/unpacked"
# shellcheck disable=SC2046 -- several flags
(cd "$out/platformio/unpacked" &&
    gcc -O0 -DRIGCAL_USE_FLOAT=1 $(/usr/bin/python3 -c '
import json
build = json.load(open("library.json"))["build"]
print(*build["flags"], "-I" + build["includeDir"])') src/*.c \
        "$OLDPWD/tests/consumers/main.c" -lm -o ../program)
check "$float" "$out/platformio/program"

# A port's own first program, from the template.
for real in 0 1; do
    gcc -std=c99 -O0 -Wall -Wextra -Wpedantic -Wconversion -Wdouble-promotion -Wshadow \
        -Werror -DRIGCAL_USE_FLOAT=$real -Iinclude port/template/main_template.c src/*.c \
        -lm -o "$out/template_$real"
    check "rigcal works" "$out/template_$real"
done

# Zephyr: Kconfig chooses by what the core has, in the same two ways.
for build in float other; do
    choices=
    [ $build != other ] || choices="CPU_HAS_FPU_DOUBLE_PRECISION=y RIGCAL_WITH_FISHEYE=n"
    # shellcheck disable=SC2046 -- several settings
    cmake -G Ninja -S $here/zephyr -B "$out/zephyr/$build" \
        -DPACKAGE="$out/zephyr/rigcal" \
        $(MODULE="$out/zephyr/rigcal/zephyr/Kconfig" "$bin/python" \
            $here/kconfig.py $here/zephyr/Kconfig RIGCAL=y $choices)
    cmake --build "$out/zephyr/$build"
done
check "$float" "$out/zephyr/float/consumer"
check "$other" "$out/zephyr/other/consumer"

echo "$count programs: Arduino, CMSIS-Pack, Conan, ESP-IDF, Meson, PlatformIO, Zephyr, template"
