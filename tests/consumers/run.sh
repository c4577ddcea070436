#!/bin/sh
# Tries the four ways to add the library to a project, each with a small project:
# find_package, pkg-config, add_subdirectory, FetchContent; static and shared, double and
# float.
#
#   sh tests/consumers/run.sh [FOLDER]     builds in FOLDER, build/consumers
set -eu
cd "$(dirname "$0")/../.."

source=$PWD
mkdir -p "${1:-build/consumers}"
out=$(cd "${1:-build/consumers}" && pwd)
rm -rf "${out:?}"/*
count=0

# Configures and builds the project $1 in $out/$2. This tests how the parts find each other,
# so no optimiser is needed.
build() {
    project=$1
    tree=$2
    shift 2
    cmake -G Ninja -S "$project" -B "$out/$tree" -DCMAKE_BUILD_TYPE=Release \
        -DCMAKE_C_FLAGS_RELEASE="-O0 -DNDEBUG" "$@"
    cmake --build "$out/$tree"
}

# check EXPECTED PROGRAM [OPTION...]: the output of the program must contain EXPECTED
check() {
    expected=$1
    shift
    said=$("$@") || { echo "consumers: $* failed: $said"; exit 1; }
    case $said in
    *"$expected"*) count=$((count + 1)) ;;
    *) echo "consumers: $* says \"$said\", not \"$expected\""; exit 1 ;;
    esac
}

for kind in static-double static-float shared-double shared-float; do
    real=${kind#*-}
    shared=OFF
    static=--static
    size="rigcal_real of 8 bytes"
    if [ "${kind%-*}" = shared ]; then
        shared=ON
        static=
    fi
    if [ "$real" = float ]; then
        size="rigcal_real of 4 bytes"
    fi
    settings="-DBUILD_SHARED_LIBS=$shared -DRIGCAL_REAL=$real"

    # Installed, then moved: nothing in the package may depend on its first place.
    # shellcheck disable=SC2086 -- several settings
    build "$source" "$kind/library" $settings \
        -DCMAKE_INSTALL_PREFIX="$out/$kind/first"
    cmake --install "$out/$kind/library"
    prefix=$out/$kind/prefix
    mv "$out/$kind/first" "$prefix"
    check "($real)" "$prefix/bin/rigcal" --version
    libdir=$(dirname "$(dirname "$(find "$prefix" -name rigcal.pc)")")

    build tests/consumers/find_package "$kind/find_package" \
        -DCMAKE_PREFIX_PATH="$prefix"
    check "$size" "$out/$kind/find_package/consumer"
    check "rigcal from C++" "$out/$kind/find_package/consumer_cxx"

    export LD_LIBRARY_PATH="$libdir"
    for options in "" $static; do
        # shellcheck disable=SC2086 -- --static or nothing
        PKG_CONFIG_PATH=$libdir/pkgconfig sh tests/consumers/pkg_config/build.sh \
            "$out/$kind/pkg_config" $options
        check "$size" "$out/$kind/pkg_config"
    done
    unset LD_LIBRARY_PATH

    # These ways pass on the two settings. Each setting is tried on and off.
    case $kind in
    static-double | shared-float) ways="add_subdirectory fetch_content" ;;
    *) ways= ;;
    esac
    for way in $ways; do
        # shellcheck disable=SC2086 -- several settings
        build "tests/consumers/$way" "$kind/$way" $settings \
            -DRIGCAL_SOURCE="$source"
        check "$size" "$out/$kind/$way/consumer"
    done
done

# A version that does not promise to be compatible with this one is refused.
sed 's/rigcal 0.2/rigcal 99.0/' tests/consumers/find_package/CMakeLists.txt \
    >"$out/CMakeLists.txt"
if cmake -G Ninja -S "$out" -B "$out/too_new" \
        -DCMAKE_PREFIX_PATH="$out/static-double/prefix" >/dev/null 2>&1; then
    echo "consumers: find_package(rigcal 99.0) was satisfied"
    exit 1
fi
echo "$count programs by find_package, pkg-config, add_subdirectory, FetchContent"
