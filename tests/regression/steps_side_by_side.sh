#!/bin/sh
# The steps of tests/run.sh that run side by side: each runs once; two that need the same
# folder never at the same time; one that fails, or is killed, is reported and stops no
# other; a signal ends all that runs.
#
#   sh tests/regression/steps_side_by_side.sh FOLDER
set -u
out=$(cd "$1" && pwd)
. tests/support/lanes.sh
state=$out/state
log=$out/log
bad=0
mkdir -p build/logs

complain() {
    echo "steps_side_by_side: $*"
    cat "$out/said.txt"
    bad=1
}

# run LANES: the steps of standard input
run() {
    rm -rf "$state"
    mkdir "$state"
    : >"$log"
    cat >"$state/steps"
    run_steps "$1" "$state/steps" >"$out/said.txt" 2>&1
}

# Each step writes when it begins and when it ends.
for lanes in 1 2 3; do
    run $lanes <<END
try-1 gcc,build/a echo + a >>$log; sleep 1; echo - a >>$log
try-2 build/a,build/b echo + a >>$log; sleep 1; echo - a >>$log
try-3 gcc echo begun; exit 3
try-4 build/b kill -KILL \$\$
try-5 nothing false || { cat $out/none; }
try-6 build/a echo + a >>$log; echo - a >>$log; echo the last line
END
    [ "$(ls "$state/ok" | tr '\n' ' ')" = "try-1 try-2 try-6 " ] ||
        complain "$lanes lanes: these are ok: $(ls "$state/ok")"
    [ "$(tr -d '\n' <"$log")" = "+ a- a+ a- a+ a- a" ] ||
        complain "$lanes lanes: the steps with the folder a: $(cat "$log")"
    [ "$(grep -c '^ok  ' "$out/said.txt") $(grep -c '^FAIL' "$out/said.txt")" = "3 3" ] ||
        complain "$lanes lanes: not 3 good and 3 bad lines"
    for line in "^FAIL  try-3: exit status 3" "^      begun$" "^FAIL  try-4: exit status 137" \
        "^FAIL  try-5: exit status 1" "^      cat: .*none" "^ok    try-6: the last line, "; do
        grep -q "$line" "$out/said.txt" || complain "$lanes lanes: no line $line"
    done
    [ -z "$(ls "$state/held")" ] || complain "$lanes lanes: folders are still held"
done

# A step that has to wait begins when it may, the others before.
rm -rf "$state"
mkdir -p "$state/waiting"
: >"$log"
: >"$state/waiting/try-1"
for n in 1 2; do
    echo "try-$n nothing echo $n >>$log"
done >"$state/steps"
{
    until grep -q 2 "$log"; do
        sleep 1
    done
    echo "may begin" >>"$log"
    rm -r "$state/waiting"
} &
run_steps 1 "$state/steps" >"$out/said.txt" 2>&1
[ "$(tr '\n' ' ' <"$log")" = "2 may begin 1 " ] ||
    complain "a step did not wait: $(cat "$log")"

# A signal while two steps wait for their programs.
rm -rf "$state"
mkdir "$state"
for n in 1 2; do
    echo "try-$n nothing sh -c 'echo \$\$ >$out/$n.pid; sleep 600; true'; true"
done >"$state/steps"
echo "try-3 nothing echo never >$out/never" >>"$state/steps"
(run_steps 2 "$state/steps") >"$out/said.txt" 2>&1 &
main=$!
until [ -s "$out/1.pid" ] && [ -s "$out/2.pid" ]; do
    sleep 1
done
kill -TERM $main
wait $main
status=$?
[ $status -eq 143 ] || complain "after SIGTERM the exit status is $status"
for n in 1 2; do
    for try in 1 2 3 4 5; do # seconds after which the program must have ended
        kill -0 "$(cat "$out/$n.pid")" 2>/dev/null || break
        sleep 1
    done
    ! kill -0 "$(cat "$out/$n.pid")" 2>/dev/null || complain "a program of step $n still runs"
done
[ ! -e "$out/never" ] || complain "a step began after the signal"

rm -f build/logs/try-*.log
[ $bad -eq 0 ] || exit 1
echo "steps in 1, 2 and 3 lanes: once each, folders shared, failures told, all ended by a signal"
