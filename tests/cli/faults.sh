# Tests of what the machine does to the tool: no memory, no disk, signals; sourced by cli.sh.

# one_line STATUS GOT TEXT WHAT: the status, and one line on stderr that holds the text
one_line() {
    (($2 == $1)) || fail "$4: exit status $2, not $1"
    [[ $(wc -l < .stderr) == 1 && $(head -c 9 .stderr) == "lamella: " ]] || fail "$4: not one line"
    grep -qF -- "$3" .stderr || fail "$4: no '$3' in the message"
}

# starved COMMAND...: under more and more address space until it is enough. `out.svg` must be all there or not at all.
starved() {
    local kilobytes=60000 failures=0 status
    while true; do
        (ulimit -v "$kilobytes"; exec "$lamella" "$@" > .stdout 2> .stderr)
        status=$?
        ((status != 0)) || break
        one_line 3 "$status" "memory" "$1 in $kilobytes kB"
        [[ ! -s .stdout ]] || fail "$1 in $kilobytes kB: wrote to stdout"
        expect_files ball.stl
        ((++failures))
        kilobytes=$((kilobytes * 9 / 8))
    done
    ((failures >= 2)) || fail "$1: $failures failures for want of memory show nothing"
}

test_memory_limit() {
    sphere ball.stl 300000
    # A sanitizer's shadow takes more address space than any limit that would bite.
    if ! (ulimit -v 4000000; "$lamella" --version) > .stdout 2> .stderr; then
        echo "not tested: this build does not start under a limit"
        return
    fi
    starved info ball.stl --threads 2
    starved slice ball.stl --layer-height 0.02 --threads 2 -o out.svg
    expect_files ball.stl out.svg
}

test_full_disk() {
    sphere ball.stl 20000
    mkdir disk
    if ! mount -t tmpfs -o size=64k tmpfs disk 2> .stderr; then
        rmdir disk
        echo "not tested: no file system can be mounted here"
        return
    fi
    trap 'umount "$folder/disk"; rm -rf "$folder"' EXIT
    expect_failure 4 "disk/out.svg': No space left" slice ball.stl -o disk/out.svg
    expect_failure 4 "disk/made.stl': No space left" make sphere --triangles 20000 -o disk/made.stl
    head -c 65536 /dev/zero > disk/filler 2> /dev/null
    expect_failure 4 "disk/report.json': No space left" slice ball.stl --report disk/report.json
    [[ $(ls -A disk) == filler ]] || fail "left on the full disk: $(ls -A disk)"
}

# signalled SIGNAL SECONDS: slicing ends as the signal says, wherever it is by then, and the old output is kept. That it was
# done before is no failure.
signalled() {
    local tool status
    echo precious > out.svg
    set -m
    "$lamella" slice ball.stl --layer-height 0.002 -o out.svg > .stdout 2> .stderr &
    set +m
    tool=$!
    sleep "$2"
    kill -s "$1" "$tool" 2> /dev/null
    wait "$tool" 2> /dev/null
    status=$?
    ((status != 0)) || return 0
    ((status == 128 + $(kill -l "$1"))) || fail "$1 after $2 s: exit status $status"
    # Before it can take signals there is nothing to say, nor to tidy up.
    [[ ! -s .stderr || $(cat .stderr) == "lamella: interrupted" ]] || fail "$1 after $2 s: not one line"
    [[ $(cat out.svg) == precious ]] || fail "$1 after $2 s: the old file is gone"
    expect_files ball.stl out.svg
}

test_signals() {
    sphere ball.stl 100000
    local signal delay
    for signal in INT TERM; do
        for delay in 0.001 0.01 0.03 0.1 0.2 0.4; do
            signalled "$signal" "$delay"
        done
    done
}
