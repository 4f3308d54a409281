#!/usr/bin/env bash
# Tests of the command-line tool. cli.sh LAMELLA TOPIC CMAKE runs the function test_TOPIC in a temporary folder.
set -uo pipefail

readonly lamella=$1 topic=$2 cmake=$3
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
readonly here
folder=$(mktemp -d)
readonly folder
trap 'rm -rf "$folder"' EXIT
cd "$folder" || exit 1

# Prints on stderr, because checks run in $(...) too.
fail() {
    {
        echo "FAILED: $*"
        echo "-- stdout"; head -c 2000 .stdout
        echo "-- stderr"; head -c 2000 .stderr
    } >&2
    exit 1
}

# expect STATUS ARGUMENT...: runs the tool and requires this exit status; leaves .stdout and .stderr.
expect() {
    local status=$1 got=0
    shift
    "$lamella" "$@" > .stdout 2> .stderr || got=$?
    ((got == status)) || fail "lamella $*: exit status $got, not $status"
}

# expect_line stdout|stderr PATTERN ARGUMENT...: requires success, and a line there that the pattern of grep is found in.
expect_line() {
    local where=$1 pattern=$2
    shift 2
    expect 0 "$@"
    grep -q -- "$pattern" ".$where" || fail "lamella $*: no '$pattern' on $where"
}

# expect_silent ARGUMENT...: requires success, and nothing on stderr.
expect_silent() {
    expect 0 "$@"
    [[ ! -s .stderr ]] || fail "lamella $*: stderr is not silent"
}

# skip REASON: what this machine cannot test is not a success; ctest counts it as skipped.
skip() {
    echo "not tested: $*"
    exit 77
}

# fails_into STATUS TEXT ARGUMENT...: requires the status, and one line on stderr that contains the text. Standard output is the
# caller's.
fails_into() {
    local status=$1 text=$2 got=0
    shift 2
    "$lamella" "$@" 2> .stderr || got=$?
    ((got == status)) || fail "lamella $*: exit status $got, not $status"
    expect_message "lamella $*" "$text"
}

# expect_failure STATUS TEXT ARGUMENT...: the same, and nothing on stdout.
expect_failure() {
    fails_into "$@" > .stdout
    [[ ! -s .stdout ]] || fail "lamella ${*:3}: wrote to stdout"
}

# expect_message CALL TEXT: requires that stderr is one line of the tool that contains the text. Starts no process: hundreds
# of checks come here.
expect_message() {
    local lines
    mapfile lines < .stderr
    [[ ${#lines[@]} == 1 && ${lines[0]} == "lamella: "*$'\n' ]] || fail "$1: not one line"
    [[ ${lines[0]} == *"$2"* ]] || fail "$1: no '$2' in the message"
}

# now_us: prints the time in microseconds. The decimal point is the locale's.
now_us() { echo "${EPOCHREALTIME/[.,]/}"; }

expect_files() {
    local found
    found=$(find . -mindepth 1 ! -name .stdout ! -name .stderr -printf '%P\n' | sort | tr '\n' ' ')
    [[ "$found" == "$*${*:+ }" ]] || fail "files are '$found', not '$*'"
}

# json_value FILE KEY...: prints the value under these keys.
json_value() {
    local file=$1 keys value
    shift
    keys=$(IFS=';'; echo "$*")
    value=$("$cmake" -DFILE="$PWD/$file" -DKEYS="$keys" -P "$here/json_value.cmake") || fail "$file is not JSON with $keys"
    printf '%s\n' "${value#-- }"
}

# members FILE KEYS...: prints values, each with its keys, which are separated by blanks.
members() {
    local file=$1 keys value
    shift
    for keys in "$@"; do
        # shellcheck disable=SC2086
        value=$(json_value "$file" $keys) || exit 1
        echo "$keys: $value"
    done
}

# result MESH KEY...: prints a value of the mesh's line in out/results.jsonl.
result() {
    grep -F "{\"mesh\":\"$1\"" out/results.jsonl > .line || fail "no line of $1"
    json_value .line "${@:2}"
    rm .line
}

# settled: the files that are here and what is in them.
settled() { find . ! -name '.std*' ! -name .actual -printf '%P %l\n' -type f -exec md5sum {} + 2> /dev/null | sort; }

# transcript NAME: runs transcripts/NAME.txt and requires that it is what comes out. A line "% WORDS" runs words of the shell, which
# must succeed; what they print follows, indented. A line "$ WORDS" runs the tool. What it prints follows, but for times, memory,
# ranges of layers and sizes of what libraries write, with "! " before each message and the exit status before that. Commands of `refusals` change no file.
# LAMELLA_UPDATE_GOLDEN=1 writes the file anew.
transcript() {
    local script=$here/transcripts/$1.txt line before="" status
    while IFS= read -r line <&3; do
        case "$line" in
            '% '*)
                [[ -z $before || $before == "$(settled)" ]] || fail "before $line: a refused command changed files"
                eval "${line#% }" > .std% < /dev/null || fail "$line"
                before="" ;;
            '$'*)
                if [[ -z $before && $1 == refusals ]]; then before=$(settled); fi
                eval "set -- $1 ${line#$}"
                "$lamella" "${@:2}" > .stdout 2> .stderr < /dev/null
                status=$? ;;
            '#'* | '') ;;
            *) continue ;;
        esac
        printf '%s\n' "$line"
        if [[ $line == '% '* ]]; then
            sed 's/^/  /' .std%
        elif [[ $line == '$'* ]]; then
            grep -avE '^(time|memory|sliced) ' .stdout | sed -E "s|$folder|FOLDER|g"'
                    s/^$/(blank)/; s/, [0-9.,]+ (bytes|kB|MB) of gzip/, of gzip/; s/, [0-9.]+ s$//; s/^(ranges +).*(of layers).*/\1\2/
                    s/^(wrote .*\.(gz|nrrd|dcm|png|h5)), .*/\1/
                    s/(\.(gz|nrrd|h5)\b.* has )[0-9,]+ bytes, its record says [0-9,]+/\1N bytes, its record says M/'
            sed -e "s|$folder|FOLDER|g; s/^lamella: /${status#0}! /; t; s/^/${status#0}? /" .stderr
            [[ $status == 0 || -s .stderr ]] || echo "$status!"
        fi
    done 3< "$script" > .actual
    [[ -z $before || $before == "$(settled)" ]] || fail "a refused command changed files"
    [[ -z ${LAMELLA_UPDATE_GOLDEN:-} ]] || cp .actual "$script"
    diff "$script" .actual >&2 || fail "another transcript of $1"
}

hash_of() { sed -n 's/^hash *//p' .stdout; }

for part in fixtures output faults; do source "$here/$part.sh"; done
if [[ -e $here/transcripts/$topic.txt ]]; then transcript "$topic"; else "test_$topic"; fi
echo "passed"
