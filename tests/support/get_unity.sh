#!/bin/sh
# Puts the three core files of Unity 2.5.1 into a folder.
#
#   sh get_unity.sh DEST
#
# Unity's code is not ours, so it is not kept here. Debian's source package
# ntpsec carries a copy under tests/unity. This script makes itself a private
# apt configuration, whose sources are the machine's own with deb-src in place
# of deb, downloads that package through the machine's own trusted keys, takes
# the three files and compares them with the checksums below. It needs no root
# and leaves the machine's apt as it was. DEST appears complete or not at all.
# Exit status 2: DEST cannot be made; 1: anything else.
set -eu

package=ntpsec
sums='2e3a0610268455520a5796345b503d00c34a47fe97ed3750349cbd4b2b1990f3  unity.c
681ac98a63ac11effb11e59d580f6ca82abca1bd34069465c38e3b15344256c0  unity.h
adfd612c217e59468c5ebe978640e77e5f539e820ffc0c195a98c5a36f0ac868  unity_internals.h'

die() {
    echo "get_unity.sh: $*" >&2
    exit 1
}

[ $# -eq 1 ] || die "usage: get_unity.sh DEST"
dest=$1

# Whether folder $1 holds exactly the files of the checksums.
is_complete() {
    [ -d "$1" ] && (cd "$1" && echo "$sums" | sha256sum -c --status 2>/dev/null)
}

if is_complete "$dest"; then
    exit 0
fi
if ! mkdir -p "$(dirname "$dest")" 2>/dev/null || ! [ -w "$(dirname "$dest")" ]
then
    echo "get_unity.sh: cannot make a folder at $dest" >&2
    exit 2
fi
command -v apt-get >/dev/null || die "there is no apt-get on this machine"

work=$(mktemp -d) || die "cannot make a temporary folder"
trap 'rm -rf "$work"' EXIT
trap 'exit 1' HUP INT TERM
mkdir -p "$work/parts" "$work/lists/partial" "$work/cache/archives/partial" \
         "$work/download"

# One-line sources: deb becomes deb-src; a CD holds no sources.
list_to_src() {
    sed -n -e '/cdrom:/d' \
        -e 's/^[[:space:]]*deb\(-src\)\{0,1\}[[:space:]]/deb-src /p' "$1"
}

# deb822 sources: the Types field of each stanza becomes deb-src.
deb822_to_src() {
    sed -e 's/^[Tt]ypes:.*/Types: deb-src/' "$1"
}

for file in /etc/apt/sources.list /etc/apt/sources.list.d/*.list; do
    [ -r "$file" ] || continue
    list_to_src "$file"
done | awk '!seen[$0]++' >"$work/sources.list"
n=0
for file in /etc/apt/sources.list.d/*.sources; do
    [ -r "$file" ] || continue
    n=$((n + 1))
    deb822_to_src "$file" >"$work/parts/$n.sources"
done
[ -s "$work/sources.list" ] || [ "$n" -gt 0 ] ||
    die "this machine's apt has no sources"

# As root, apt would download as the user _apt, who has no access to our folder.
private_apt() {
    apt-get -q -o Dir::Etc::SourceList="$work/sources.list" \
        -o Dir::Etc::SourceParts="$work/parts" \
        -o Dir::State::Lists="$work/lists" \
        -o Dir::Cache="$work/cache" \
        -o Acquire::Languages=none \
        -o Acquire::Retries=2 \
        -o APT::Sandbox::User="$(id -un)" \
        -o APT::Update::Post-Invoke-Success::= \
        "$@"
}

# If a third-party source has no deb-src, the update fails as a whole although the others
# were read. So only whether the package is found counts.
private_apt update >"$work/log" 2>&1 || true
if ! (cd "$work/download" &&
      private_apt source --download-only "$package" >>"$work/log" 2>&1); then
    tail -n 5 "$work/log" | sed 's/^/    /' >&2
    die "apt could not download the source package $package"
fi

tarball=$(find "$work/download" -name "${package}_*.orig.tar.*" \
               ! -name '*.asc' | head -n 1)
[ -n "$tarball" ] || die "the source package $package has no orig tarball"
mkdir "$work/tree"
tar -xf "$tarball" -C "$work/tree" --strip-components=1 --wildcards \
    '*/tests/unity/unity.c' '*/tests/unity/unity.h' \
    '*/tests/unity/unity_internals.h' ||
    die "$(basename "$tarball") does not hold tests/unity"

is_complete "$work/tree/tests/unity" ||
    die "$(basename "$tarball") carries a Unity that is not 2.5.1 as known here"

# Moves the folder into place at once. If another build was faster, that is no failure.
ready=$(mktemp -d "$dest.XXXXXX")
cp "$work/tree/tests/unity/"unity*.[ch] "$ready"
chmod 755 "$ready"
[ ! -d "$dest" ] || rm -rf "$dest"
mv -T "$ready" "$dest" 2>/dev/null || rm -rf "$ready"
is_complete "$dest" || die "could not put the files in $dest"
