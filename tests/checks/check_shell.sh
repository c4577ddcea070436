#Lets the shell parse every script, also those that CI does not run.
set -eu
cd "$(dirname "$0")/../.."

scripts=$(find . \( -name build -o -name .git \) -prune -o -name '*.sh' -print)
for script in $scripts; do
    sh -n "$script"
done
echo "$(echo "$scripts" | wc -l) scripts"
