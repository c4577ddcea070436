# Sourced by tests/run.sh: steps side by side.
#
#   run_steps LANES FILE   FILE has a step a line: NAME NEEDS COMMAND. Each of the LANES
#                          takes the first step that nobody has taken, runs it, prints its
#                          line, and takes the next. Afterwards "$state/ok" has a file for
#                          each step that ended well.
#
# NEEDS, a list with commas, may name folders, build/NAME: no two steps that need the same
# one run at the same time.
#
# A step for which there is a file "$state/waiting/NAME" begins when that is gone.
#
# mkdir makes a folder once, whoever asks: "$state/taken/NAME" is made by the lane that runs
# the step, "$state/held/FOLDER" by the lane whose step needs build/FOLDER.

# Each step is a group of processes, so that all of it can be ended.
own_group=$(command -v setsid) || own_group=

# The step's log in one phrase: ctest's count, or the last line.
summary() {
    if count=$(sed -n 's/.* tests failed out of \([0-9]*\)$/\1 tests/p' "$1") &&
            [ -n "$count" ]; then
        echo "$count"
    else
        tail -n 1 "$1"
    fi
}

# Sets `folders` to the folders that the needs $1 name.
folders_of() {
    folders=$(echo "$1" | tr ',' '\n' | sed -n 's|^build/||p')
}

# Takes all folders that the needs $1 name, or none.
hold() {
    folders_of "$1"
    held=
    for folder in $folders; do
        if ! mkdir "$state/held/$folder" 2>/dev/null; then
            give_back "$held"
            return 1
        fi
        held="$held $folder"
    done
}

give_back() {
    for folder in $1; do
        rmdir "$state/held/$folder"
    done
}

end_step() {
    if [ -n "$step" ]; then
        kill -s TERM -- "${own_group:+-}$step" 2>/dev/null
    fi
    exit 143
}

# Adds up what "times" wrote into the files, one for each step: a line with the shell's own
# time, and one with that of its children.
processor_seconds() {
    cat "$@" | awk '{gsub("s", ""); for (i = 1; i <= 2; i++) {
        split($i, t, "m"); sum += 60 * t[1] + t[2]}} END {printf "%.0f", sum}'
}

# run_step NAME COMMAND: the "times" of its shell are the processor seconds of the step.
run_step() {
    log=build/logs/$1.log
    begin=$(date +%s)
    # shellcheck disable=SC2016 -- for that shell
    $own_group sh -c '. tests/support/steps.sh
        trap '\''times >"$2"'\'' EXIT
        eval "$1"' "$1" "$2" "$state/times/$1" >"$log" 2>&1 </dev/null &
    step=$!
    wait "$step"
    status=$?
    step=
    took="$(($(date +%s) - begin)) s"
    if [ -s "$state/times/$1" ]; then
        took="$took ($(processor_seconds "$state/times/$1") s of a processor)"
    fi
    if [ $status -eq 0 ]; then
        : >"$state/ok/$1"
        echo "ok    $1: $(summary "$log"), $took"
    else
        # In one piece, because another lane may print at the same time.
        {
            echo "FAIL  $1: exit status $status, $took; the end of $log:"
            tail -n 30 "$log" | sed 's/^/      /'
        } >"$state/failure.$1"
        cat "$state/failure.$1"
    fi
}

# lane FILE
lane() {
    step=
    trap end_step TERM HUP
    left=yes
    while [ -n "$left" ]; do
        left=
        while read -r name needs command <&3; do
            [ ! -e "$state/taken/$name" ] || continue
            if [ -e "$state/waiting/$name" ] || ! hold "$needs"; then
                left=later
                continue
            fi
            mine=$held
            if mkdir "$state/taken/$name" 2>/dev/null; then
                run_step "$name" "$command"
                left=now
            fi
            give_back "$mine"
            [ "$left" != now ] || break
        done 3<"$1"
        [ "$left" != later ] || sleep 1
    done
}

run_steps() {
    mkdir "$state/taken" "$state/held" "$state/times" "$state/ok" || return 1
    lanes=
    trap 'stop_lanes INT 130' INT
    trap 'stop_lanes TERM 143' TERM
    trap 'stop_lanes HUP 129' HUP
    while [ "$(echo "$lanes" | wc -w)" -lt "$1" ]; do
        lane "$2" &
        lanes="$lanes $!"
    done
    for one in $lanes; do
        wait "$one"
    done
    trap - INT TERM HUP
}

stop_lanes() {
    trap '' INT TERM HUP
    # shellcheck disable=SC2086 -- a list
    kill -s TERM $lanes 2>/dev/null
    for one in $lanes; do
        wait "$one"
    done
    echo "Stopped by $1. What ran is ended; the logs are in build/logs."
    exit "$2"
}
