#!/bin/sh
# All C and C++ is as clang-format writes it (Debian 12's, version 14: others lay out some
# lines otherwise), and no line of a comment is longer than 92 columns, which clang-format
# leaves as they are.
set -eu
cd "$(dirname "$0")/../.."

columns=$(sed -n 's/^ColumnLimit: //p' .clang-format)

# The files that git keeps, or all files if this is no git tree. The vectors are left out,
# because a program writes them.
list() {
    if git rev-parse --is-inside-work-tree >/dev/null 2>&1; then
        git ls-files
    else
        find include src tests port examples -type f
    fi | grep -E '\.(c|h|cpp|ino)$' | grep -v '^tests/vectors/vectors_'
}

case $(clang-format --version) in
*"version 14."*) ;;
*)
    echo "check_format: this wants clang-format 14, and there is $(clang-format --version)"
    exit 1
    ;;
esac

list | xargs clang-format --dry-run -Werror

# A comment, or the end of one after code. "#error" is not a comment.
long=$(list | xargs awk -v columns="$columns" '
    FNR == 1 {inside = 0}
    {
        comment = inside || index($0, "/*") || index($0, "//")
        if (match($0, /.*\/\*/)) {
            inside = !index(substr($0, RLENGTH + 1), "*/")
        } else if (index($0, "*/")) {
            inside = 0
        }
        if (comment && length($0) > columns) {
            print FILENAME ":" FNR ": a comment of " length($0) " columns"
        }
    }')
if [ -n "$long" ]; then
    echo "$long"
    echo "check_format: comments have at most $columns columns"
    exit 1
fi
echo "$(list | wc -l) files as clang-format writes them, comments within $columns columns"
