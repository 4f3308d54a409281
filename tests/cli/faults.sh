# Tests of the tool without memory or disk space, under signals, and of its processes that die; sourced by cli.sh.

# one_line STATUS GOT TEXT WHAT: requires the status, and one line on stderr that contains the text
one_line() {
    (($2 == $1)) || fail "$4: exit status $2, not $1"
    expect_message "$4" "$3"
}

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
        one_line 3 "$status" "memory" "$* in $kilobytes kB"
        [[ ! -s .stdout ]] || fail "$* in $kilobytes kB: wrote to stdout"
        [[ ! -e out.svg ]] || fail "$* in $kilobytes kB: an output"
        [[ -z $(compgen -G ".out.svg*") ]] || fail "$* in $kilobytes kB: left something aside"
        ((++failures))
    done
    ((failures >= 2)) || fail "$*: $failures failures for want of memory show nothing"
}

# three_mf FILE TRIANGLES: writes a fan of triangles
three_mf() {
    mkdir -p package/_rels package/3D
    local types=http://schemas.openxmlformats.org/package/2006
    printf '<Types xmlns="%s/content-types"><Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>' \
        "$types" > 'package/[Content_Types].xml'
    printf '<Relationships xmlns="%s/relationships"><Relationship Id="r" Target="/3D/3dmodel.model" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>' \
        "$types" > package/_rels/.rels
    awk -v n="$2" 'BEGIN {
        print "<model unit=\"millimeter\" xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\"><resources><object id=\"1\"><mesh><vertices>"
        for (i = 0; i < n + 2; ++i) printf "<vertex x=\"%d\" y=\"%d\" z=\"%d\"/>\n", i, i % 7, i % 5
        print "</vertices><triangles>"
        for (i = 1; i <= n; ++i) printf "<triangle v1=\"0\" v2=\"%d\" v3=\"%d\"/>\n", i, i + 1
        print "</triangles></mesh></object></resources><build><item objectid=\"1\"/></build></model>"
    }' > package/3D/3dmodel.model
    (cd package && "$cmake" -E tar cf "../$1" --format=zip '[Content_Types].xml' _rels 3D) || fail "no 3MF made"
    rm -r package
}

test_memory_limit() {
    sphere ball.stl 300000
    # A sanitizer's shadow memory needs more address space than any useful limit.
    (ulimit -v 4000000; "$lamella" --version) > .stdout 2> .stderr || skip "this build does not start under a limit"
    gzip -1k ball.stl
    three_mf fan.3mf 50000
    expect 0 info fan.3mf
    local file
    for file in ball.stl ball.stl.gz fan.3mf; do
        starved info "$file" --threads 2
    done
    starved check ball.stl --threads 2
    starved slice ball.stl --layer-height 0.02 --threads 2 -o out.svg
    rm out.svg
    starved slice ball.stl --weld 0.001 --threads 2 -o out.svg
    rm out.svg
    starved slice ball.stl --fill-rule positive --threads 2 -o out.svg
    expect_files ball.stl ball.stl.gz fan.3mf out.svg
}

test_full_disk() {
    sphere ball.stl 20000
    mkdir disk
    if ! mount -t tmpfs -o size=64k tmpfs disk 2> .stderr; then
        rmdir disk
        skip "no file system can be mounted here"
    fi
    trap 'umount "$folder/disk"; rm -rf "$folder"' EXIT
    expect_failure 4 "disk/out.svg': No space left" slice ball.stl -o disk/out.svg
    expect_failure 4 "disk/made.stl': No space left" make sphere --triangles 20000 -o disk/made.stl
    head -c 65536 /dev/zero > disk/filler 2> /dev/null
    expect_failure 4 "disk/report.json': No space left" slice ball.stl --report disk/report.json
    [[ $(ls -A disk) == filler ]] || fail "left on the full disk: $(ls -A disk)"
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

# Slicing ends with a signal, whatever it is doing, and keeps the old output.
test_signals() {
    sphere ball.stl 100000
    local signal delay
    for signal in INT TERM; do
        for delay in 0.001 0.01 0.03 0.1 0.2 0.4; do
            echo precious > out.svg
            ended_by "$signal" "$delay" slice ball.stl --layer-height 0.002 -o out.svg
            [[ $(cat out.svg) == precious || ! -s .stderr ]] || fail "$signal after $delay s: the old file is gone"
            expect_files ball.stl out.svg
        done
    done
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
        for command in "out.svg slice ball.stl --layer-height 0.002" "made.stl make bone --triangles 1000000"; do
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
    local reader tool signal begin
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
}

# The report reads the mesh again after the SVG. The file is truncated once the SVG is being written.
test_shrinking_map() {
    local status tool
    while_writing out.svg ': > ball.stl' slice ball.stl --map --layer-height 0.005 -o out.svg --report report.json
    one_line 3 "$status" "ball.stl: shrank while it was read" "a mapped file"
    [[ ! -s .stdout ]] || fail "wrote to stdout"
    expect_files ball.stl out.svg
}

# stopped_at_random ARGUMENT...: ends the command twice, at random moments of the time that it takes.
stopped_at_random() {
    local begin whole
    begin=$(now_us)
    expect 0 "$@"
    whole=$((($(now_us) - begin) / 1000))
    for _ in 1 2; do
        ended_by INT "$(awk -v ms="$((RANDOM * whole / 32768))" 'BEGIN { printf "%.3f", ms / 1000 }')" "$@"
    done
    rm -f out.svg report.json marks.ply again.stl
}

# Every command on a mesh of a million triangles.
test_stops() {
    expect 0 make bone --triangles 1000000 -o bone.stl
    stopped_at_random make bone --triangles 1000000 -o again.stl
    stopped_at_random info bone.stl
    stopped_at_random check bone.stl --report report.json --marks marks.ply
    stopped_at_random slice bone.stl --layer-height 0.1
    stopped_at_random slice bone.stl --layer-height 0.1 --fill-rule non-zero
    stopped_at_random slice bone.stl --layer-height 0.1 --weld 0.0001 -o out.svg
    stopped_at_random slice bone.stl --layer-height 0.1 --report report.json
    expect_files bone.stl
}

# next_worker BATCH: waits for a process that slices a mesh, and prints its number.
next_worker() { until pgrep -P "$1"; do kill -0 "$1" 2> /dev/null || fail "the batch has ended"; sleep 0.05; done; }

# writing_worker BATCH: the same, once it writes slow.nii.gz aside: under a name with its number, unlike what others left.
writing_worker() {
    local worker
    worker=$(next_worker "$1") || exit 1
    until compgen -G "out/.slow*.$worker-*" > /dev/null; do
        kill -0 "$worker" 2> /dev/null || fail "the process has ended"
        sleep 0.05
    done
    echo "$worker"
}

# expect_end PROCESS: it ends soon.
expect_end() {
    for _ in $(seq 100); do kill -0 "$1" 2> /dev/null || return 0; sleep 0.05; done
    fail "a process outlives its batch"
}

# What becomes of a process ends its mesh, and not the batch.
test_batch_processes() {
    meshes
    rm in/bad.stl
    expect 0 make sphere --triangles 1000 --height 150 -o slow.stl
    echo '{"path":"slow.stl","spacing":[0.1,0.1,0.1],"subslices":100,"frame":"lps","output":"out/slow.nii.gz"}' > slow.jsonl
    expect 5 batch in slow.jsonl -o 'out/{stem}.csv' --timeout 2 --retries 0
    grep -qF "meshes    5: 4 done, 0 unchanged, 1 failed" .stdout || fail "not all others are done"
    [[ $(result slow.stl reason) == "took longer than 2 s" ]] || fail "no time-out"
    # A mesh whose process is killed is tried again.
    "$lamella" batch slow.jsonl -o 'out/{stem}.csv' --retries 1 > .stdout 2> .stderr &
    local batch=$! worker
    for _ in 1 2; do
        worker=$(next_worker "$batch") || exit 1
        kill -9 "$worker"
        while kill -0 "$worker" 2> /dev/null; do sleep 0.05; done
    done
    wait "$batch"
    [[ $? == 5 ]] || fail "a killed process: not status 5"
    [[ $(result slow.stl reason) == "ended by signal 9 (Killed)" ]] || fail "not the signal"
    # Two batches do not write one results.jsonl.
    "$lamella" batch slow.jsonl -o 'out/{stem}.csv' > .stdout 2> .stderr &
    batch=$!
    worker=$(writing_worker "$batch") || exit 1
    expect_failure 4 "another lamella batch is at work" batch in/s1.stl -o 'out/{stem}.csv'
    # Processes die with their batch; the next one removes what they left.
    kill -9 "$batch"
    wait "$batch" 2> /dev/null
    expect_end "$worker"
    compgen -G 'out/.slow*' > /dev/null || fail "nothing is left to be removed"
    expect 5 batch slow.jsonl -o 'out/{stem}.csv' --timeout 0.1 --retries 0
    ! compgen -G 'out/.*.part' > /dev/null || fail "a file aside is left"
    # SIGTERM ends processes and batch, and leaves nothing half-written.
    "$lamella" batch slow.jsonl -o 'out/{stem}.csv' > .stdout 2> .stderr &
    batch=$!
    writing_worker "$batch" > .worker || exit 1
    kill -TERM "$batch"
    wait "$batch"
    [[ $? == 143 && $(cat .stderr) == "lamella: interrupted" ]] || fail "SIGTERM: not status 143 with one line"
    ! compgen -G 'out/.*.part' > /dev/null || fail "a file aside is left by SIGTERM"
}
