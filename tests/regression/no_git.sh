#!/bin/sh
# Where there is no git, or the sources are no checkout, as in a release's archive, the steps
# `proof` and `matrix` of tests/run.sh failed, because they could not tell the commit.
#
#   sh tests/regression/no_git.sh FOLDER
set -eu
out=$(cd "$1" && pwd)
. tests/support/packages.sh

without=$(PATH=$out && commit_of src) # no program at all
elsewhere=$(GIT_DIR=$out/none commit_of src)
[ "$without, $elsewhere" = "not known, not known" ] ||
    { echo "no_git: the commit is \"$without\" without git, \"$elsewhere\" elsewhere"; exit 1; }

# No step may ask git in another way and end if that fails.
asks=$(grep -ln "git rev-parse --short" tests/*/*.sh || true)
for script in $asks; do
    case $script in
    tests/support/packages.sh | tests/regression/no_git.sh) ;;
    *)
        echo "no_git: $script does not use commit_of"
        exit 1
        ;;
    esac
done
echo "a commit that is not known stops nothing"
