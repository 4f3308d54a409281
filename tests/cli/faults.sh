# Tests of the tool without memory or disk space, under signals, and of its processes that die; sourced by cli.sh.

# starved COMMAND...: runs the tool under growing limits of address space until it succeeds. `out.svg` must be complete or
# absent.
starved() {
    local kilobytes=20000 failures=0 status
    for (( ; ; kilobytes = kilobytes * 17 / 16)); do
        (ulimit -v "$kilobytes"; exec "$lamella" "$@" > .stdout 2> .stderr)
        status=$?
        # The limit is so low that the system cannot even load the libraries.
        ((status != 127)) || continue
        ((status != 0)) || break
        ((status == 3)) || fail "$* in $kilobytes kB: exit status $status"
        expect_message "$* in $kilobytes kB" "memory"
        [[ ! -s .stdout ]] || fail "$* in $kilobytes kB: wrote to stdout"
        [[ ! -e out.svg ]] || fail "$* in $kilobytes kB: an output"
        [[ -z $(compgen -G ".out.svg*") ]] || fail "$* in $kilobytes kB: left something aside"
        ((++failures))
    done
    ((failures >= 2)) || fail "$*: $failures failures for want of memory show nothing"
}

test_memory_limit() {
    sphere ball.stl 300000
    # A sanitizer's shadow memory needs more address space than any useful limit.
    (ulimit -v 4000000; "$lamella" --version) > .stdout 2> .stderr || skip "this build does not start under a limit"
    gzip -1k ball.stl
    starved info ball.stl --threads 2
    starved info ball.stl.gz --threads 2
    starved check ball.stl --threads 2
    local options
    for options in "--layer-height 0.02" "--weld 0.001" "--fill-rule positive"; do
        # shellcheck disable=SC2086
        starved slice ball.stl $options --threads 2 -o out.svg
        rm out.svg
    done
    expect_files ball.stl ball.stl.gz
}

# start_tool ARGUMENT...: starts the command line tool beside this script; its process is `tool`.
start_tool() {
    set -m  # A background job ignores SIGINT unless job control gives it its own process group.
    "$lamella" "$@" > .stdout 2> .stderr &
    set +m
    tool=$!
    # Until exec, the child is a copy of this script, with its trap.
    while [[ "$(cat "/proc/$tool/comm")" == bash ]]; do :; done
}

# ended_by SIGNAL SECONDS ARGUMENT...: the command ends with the signal at most half a second after it, which leaves room for
# freeing memory and for a busy machine. Finishing before the signal is not a failure. Before the tool can handle signals,
# there is nothing to print.
ended_by() {
    local signal=$1 delay=$2 tool status begin
    shift 2
    start_tool "$@"
    sleep "$delay"
    kill -s "$signal" "$tool" 2> /dev/null
    begin=$(now_us)
    wait "$tool" 2> /dev/null
    status=$?
    (($(now_us) - begin < 500000)) || fail "$*: went on for over half a second"
    ((status == 0 || status == 128 + $(kill -l "$signal"))) || fail "$*: exit status $status"
    [[ ! -s .stderr || $(tail -c 21 .stderr) == "lamella: interrupted" || $status == 0 ]] || fail "$*: another message"
}

# while_writing OUTPUT WORDS ARGUMENT...: runs the words when the tool writes the file aside, and waits for its end with `status`.
# Where the tool has finished earlier, all is repeated.
while_writing() {
    local output=$1 words=$2
    shift 2
    for _ in 1 2 3 4 5; do
        sphere ball.stl 100000
        rm -f "$output" report.json
        start_tool "$@"
        until compgen -G ".$output.*" > /dev/null || ! kill -0 "$tool" 2> /dev/null; do :; done
        eval "$words" 2> /dev/null
        wait "$tool" 2> /dev/null
        status=$?
        ((status == 0)) || break
    done
}

test_interrupt() {
    local signal command status tool
    for signal in INT TERM; do
        for command in "out.svg slice ball.stl --layer-height 0.002" "made.stl make bone --triangles 1000000" \
            out.{cli,3mf,dxf,geojson,vtp}" slice ball.stl --layer-height 0.002" \
            "out.zip slice ball.stl --layer-height 0.01 --screen 4096x4096 --pixel 0.05"; do
            # shellcheck disable=SC2016,SC2086
            while_writing ${command%% *} 'kill -s "$signal" "$tool"' ${command#* } -o ${command%% *}
            ((status == 128 + $(kill -l "$signal"))) || fail "$command, $signal: exit status $status"
            [[ $(cat .stderr) == "lamella: interrupted" ]] || fail "$command, $signal: not one line"
            expect_files ball.stl
        done
    done
}

# Nobody reads the pipe, so the command waits for a place in it and cannot look for the first signal.
test_second_signal() {
    sphere ball.stl 100000
    echo precious > out.svg
    mkfifo pipe
    local reader tool signal begin command status
    for signal in INT TERM; do
        sleep 60 < pipe &
        reader=$!
        set -m
        "$lamella" slice ball.stl --layer-height 0.01 --report out.svg -o - > pipe 2> .stderr &
        set +m
        tool=$!
        sleep 1
        kill -s "$signal" "$tool"
        sleep 0.3
        kill -0 "$tool" 2> /dev/null || fail "$signal: ended before the second one"
        begin=$(now_us)
        kill -s "$signal" "$tool"
        wait "$tool" 2> /dev/null
        (($? == 128 + $(kill -l "$signal"))) || fail "$signal: another exit status"
        (($(now_us) - begin < 1000000)) || fail "$signal: over a second"
        [[ $(cat .stderr) == "lamella: interrupted" ]] || fail "$signal: not one line"
        [[ $(cat out.svg) == precious ]] || fail "$signal: the old file is gone"
        kill "$reader"
        wait "$reader" 2> /dev/null
        expect_files ball.stl out.svg pipe
    done
    for command in info check; do  # one signal ends what waits for its next mesh
        sleep 60 > pipe &
        reader=$!
        start_tool "$command" ball.stl - < pipe
        sleep 1
        kill "$tool"
        status=0
        wait "$tool" || status=$?
        kill "$reader"
        ((status == 128 + 15)) || fail "$command: exit status $status"
    done
}

# The report reads the mesh again after the SVG. The file is truncated once the SVG is being written.
test_shrinking_map() {
    local status tool
    while_writing out.svg ': > ball.stl' slice ball.stl --map --layer-height 0.005 -o out.svg --report report.json
    expect_message "a mapped file" "ball.stl: shrank while it was read"
    [[ $status == 3 && ! -s .stdout ]] || fail "exit status $status, or words on stdout"
    expect_files ball.stl out.svg
}

# stopped_at_random ARGUMENT...: ends the command by each signal, at random moments of the time that it takes. Old outputs stay.
stopped_at_random() {
    local begin whole signal
    begin=$(now_us)
    expect 0 "$@"
    whole=$((($(now_us) - begin) / 1000))
    for signal in INT TERM INT; do
        echo precious | tee out.svg > again.stl
        ended_by "$signal" "$(awk -v ms="$((RANDOM * whole / 32768))" 'BEGIN { printf "%.3f", ms / 1000 }')" "$@"
        [[ ! -s .stderr || $(cat out.svg again.stl) == $'precious\nprecious' ]] || fail "$*: an old file is gone"
        rm -f out.svg report.json marks.ply again.stl
    done
    expect_files bone.stl
}

# Every command on a mesh of a million triangles.
test_stops() {
    expect 0 make bone --triangles 1000000 -o bone.stl
    local command
    for command in "make bone --triangles 1000000 -o again.stl" "info bone.stl" "check bone.stl --report report.json --marks marks.ply" \
        "slice bone.stl --layer-height 0.1 --fill-rule contours" "slice bone.stl --layer-height 0.1 --weld 0.0001 -o out.svg" \
        "slice bone.stl --layer-height 0.1 -o out.svg" "slice bone.stl --layer-height 0.1 --report report.json"; do
        # shellcheck disable=SC2086
        stopped_at_random $command
    done
}

# slow_batch WORD...: starts a batch of the slow mesh beside this script; its process is `batch`.
slow_batch() {
    "$lamella" batch slow.jsonl -o 'out/{stem}.csv' "$@" > .stdout 2> .stderr &
    batch=$!
}

# Waits for a process of the batch that slices a mesh: `worker`.
next_worker() { until worker=$(pgrep -P "$batch"); do kill -0 "$batch" 2> /dev/null || fail "the batch has ended"; sleep 0.05; done; }

# The same, once it writes slow.nii.gz aside: under a name with its number, unlike what others left.
writing_worker() {
    next_worker
    until compgen -G "out/.slow*.$worker-*" > /dev/null; do kill -0 "$worker" 2> /dev/null || fail "the process has ended"; sleep 0.05; done
}

# What becomes of a process ends its mesh, and not the batch.
test_batch_processes() {
    local batch worker
    meshes
    rm in/bad.stl
    expect 0 make sphere --triangles 1000 --height 150 -o slow.stl
    echo '{"path":"slow.stl","spacing":[0.1,0.1,0.1],"subslices":100,"frame":"lps","output":"out/slow.nii.gz"}' > slow.jsonl
    expect 5 batch in slow.jsonl -o 'out/{stem}.csv' --timeout 2 --retries 0
    grep -qF "meshes    5: 4 done, 0 unchanged, 1 failed" .stdout || fail "not all others are done"
    [[ $(result slow.stl reason) == "took longer than 2 s" ]] || fail "no time-out"
    # A mesh whose process is killed is tried again.
    slow_batch --retries 1
    for _ in 1 2; do
        next_worker
        kill -9 "$worker"
        while kill -0 "$worker" 2> /dev/null; do sleep 0.05; done
    done
    wait "$batch"
    [[ $? == 5 && $(result slow.stl reason) == "ended by signal 9 (Killed)" ]] || fail "a killed process: not status 5, or not the signal"
    # Two batches do not write one results.jsonl.
    slow_batch
    writing_worker
    expect_failure 4 "another lamella batch is at work" batch in/s1.stl -o 'out/{stem}.csv'
    # Processes die with their batch; the next one removes what they left.
    kill -9 "$batch"
    wait "$batch" 2> /dev/null
    for _ in {1..100}; do ! kill -0 "$worker" 2> /dev/null || sleep 0.05; done
    ! kill -0 "$worker" 2> /dev/null || fail "a process outlives its batch"
    compgen -G 'out/.slow*' > /dev/null || fail "nothing is left to be removed"
    expect 5 batch slow.jsonl -o 'out/{stem}.csv' --timeout 0.1 --retries 0
    ! compgen -G 'out/.*.part' > /dev/null || fail "a file aside is left"
    # SIGTERM ends processes and batch, and leaves nothing half-written.
    slow_batch
    writing_worker
    kill -TERM "$batch"
    wait "$batch"
    [[ $? == 143 && $(cat .stderr) == "lamella: interrupted" ]] || fail "SIGTERM: not status 143 with one line"
    ! compgen -G 'out/.*.part' > /dev/null || fail "a file aside is left by SIGTERM"
}
