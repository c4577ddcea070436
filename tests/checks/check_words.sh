#!/bin/sh
# Nothing in the tree names a folder of one person's machine, and nothing is
# left to do without the number of its issue.
set -eu
cd "$(dirname "$0")/../.."

# What git keeps, or all files where this is no git tree (a release's archive).
# Not this file, which must name what it looks for.
list() {
    if git rev-parse --is-inside-work-tree >/dev/null 2>&1; then
        git ls-files -z
    else
        find . \( -name build -o -name .git -o -name __pycache__ \) -prune -o \
            -type f -print0
    fi | grep -zv 'tests/checks/check_words.sh$'
}

# Lines of text files that match pattern $1 but not pattern $2.
find_words() {
    list | xargs -0 grep -InE -e "$1" | grep -Ev -e "$2" || true
}

bad=$(find_words '(^|[^[:alnum:]_.])/(home|root|work|Users)/' '^$'
      find_words '\b(TODO|FIXME|XXX)\b' '(TODO|FIXME|XXX) ?\(?#[0-9]+')
if [ -n "$bad" ]; then
    echo "$bad"
    echo "check_words: the lines above name a machine's folder, or a TODO without #issue"
    exit 1
fi
echo "$(list | tr '\0' '\n' | wc -l) files, no machine's folders, no TODO without an issue"
