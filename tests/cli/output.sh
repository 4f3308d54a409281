# What the tool writes, prints and leaves behind; sourced by cli.sh.

test_bad_output() {
    sphere ball.stl
    mkdir folder
    expect_failure 4 "none/out.svg" slice ball.stl -o none/out.svg
    expect_failure 4 "folder" slice ball.stl -o folder
    expect_failure 4 "ball.stl/out.svg" slice ball.stl -o ball.stl/out.svg
    expect_failure 4 "No space left" slice ball.stl -o /dev/full
    expect_failure 4 "No space left" slice ball.stl --report /dev/full
    expect_failure 4 "none/r.json" slice ball.stl --report none/r.json
    expect_failure 4 "none/a.stl" make sphere --triangles 1000 -o none/a.stl
    expect_failure 4 "folder" make sphere --triangles 1000 -o folder
    "$lamella" slice ball.stl > /dev/full 2> .stderr
    [[ $? == 4 && $(wc -l < .stderr) == 1 ]] || fail "stdout full: not status 4 with one line"
    "$lamella" info ball.stl > /dev/full 2> .stderr
    [[ $? == 4 && $(wc -l < .stderr) == 1 ]] || fail "info, stdout full: not status 4 with one line"
    expect_files ball.stl folder
}

test_no_partial_output() {
    sphere ball.stl 20000
    echo precious > out.svg
    # A limit on file size behaves like a disk that fills up.
    (ulimit -f 64; "$lamella" slice ball.stl -o out.svg > .stdout 2> .stderr)
    [[ $? == 4 && $(wc -l < .stderr) == 1 ]] || fail "not status 4 with one line"
    grep -q "out.svg" .stderr || fail "the message does not name the file"
    [[ $(cat out.svg) == precious ]] || fail "the old file is gone"
    expect_files ball.stl out.svg
    rm out.svg
    (ulimit -f 64; "$lamella" make sphere --triangles 20000 -o other.stl > .stdout 2> .stderr)
    [[ $? == 4 && $(wc -l < .stderr) == 1 ]] || fail "make: not status 4 with one line"
    expect_files ball.stl
}

# interrupted SIGNAL OUTPUT ARGUMENT...: sends the signal when the temporary file appears. Sometimes the tool finishes
# earlier; then the test is repeated.
interrupted() {
    local signal=$1 output=$2 attempt status tool
    shift 2
    for attempt in 1 2 3 4 5; do
        # A background job ignores SIGINT unless job control gives it its own process group.
        set -m
        "$lamella" "$@" -o "$output" > .stdout 2> .stderr &
        set +m
        tool=$!
        until compgen -G ".$output.*" > /dev/null || ! kill -0 "$tool" 2> /dev/null; do :; done
        kill -s "$signal" "$tool" 2> /dev/null
        wait "$tool" 2> /dev/null
        status=$?
        ((status == 0)) || break
        rm "$output"
    done
    ((status == 128 + $(kill -l "$signal"))) || fail "$1, $signal: exit status $status"
    [[ $(cat .stderr) == "lamella: interrupted" ]] || fail "$1, $signal: not one line"
    expect_files ball.stl
}

test_interrupt() {
    sphere ball.stl 20000
    local signal
    for signal in INT TERM; do
        interrupted "$signal" out.svg slice ball.stl --layer-height 0.002
        interrupted "$signal" made.stl make bone --triangles 1000000
    done
}

test_report_stdout() {
    sphere ball.stl
    expect 0 slice ball.stl --layer-height 0.5 -o ball.svg --report -
    cp .stdout report.json
    expect_members report.json triangles=1000 planes=40 contours=40 holes=0 open_contours=0 degenerate=0 \
        mesh=ball.stl output=ball.svg 'plan side=below' 'plan datum=mesh-min' 'plan kind=uniform'
    local key
    for key in segments grid_mm threads peak_rss_bytes output_hash "ms read" "ms bucket" "ms sweep" "ms contours" "ms nesting" \
        "ms write" "ms total"; do
        # shellcheck disable=SC2086
        json_value report.json $key > /dev/null || exit 1
    done
    grep -q '^contours  40' .stderr || fail "no summary on stderr"
    [[ $(tail -c 2 report.json | head -c 1) == "}" ]] || fail "something follows the JSON"
    "$lamella" slice ball.stl --report - > /dev/full 2> .stderr
    [[ $? == 4 ]] || fail "a report that cannot be written: not status 4"
    grep -q '^lamella: cannot write to standard output: No space left' .stderr || fail "no reason given"
}

test_summary() {
    sphere ball.stl
    expect_silent slice ball.stl --layer-height 0.5 -o ball.svg --report ball.json
    local word
    for word in mesh planes rounding segments contours unseen volume time memory wrote report; do
        grep -q "^$word " .stdout || fail "no line '$word'"
    done
    grep -q '^unseen .* shells 0, peaks 1, pits 1,' .stdout || fail "not one top and one bottom"
    grep -q '^volume .* mm3, certified' .stdout || fail "the volume is not certified"
    expect_json ball.json holds volume verdict
    expect_json ball.json 0 crossings count
    expect_files ball.json ball.stl ball.svg
    [[ $(grep -c '<g id="layer' ball.svg) == 40 ]] || fail "not 40 layers"
    [[ $(grep -c 'slic3r:type="contour"' ball.svg) == 40 ]] || fail "not 40 contours"
    if command -v xmllint > /dev/null; then
        xmllint --noout --huge ball.svg || fail "not XML"
    fi
}

test_plurals() {
    { echo solid; facet $'vertex 0 0 0\nvertex 1 0 0\nvertex 0 0 1\n'; echo endsolid; } > one.stl
    expect_line stdout '^mesh .* 1 triangle, ' slice one.stl --planes 0.5 -o out.svg
    grep -q '<title>1 layer</title>' out.svg || fail "not 1 layer"
    grep -q 'Planes: 1 plane at ' out.svg || fail "not 1 plane"
    expect_line stdout ', 1 triangle, triangle 0$' check one.stl
    printf 'ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 2
property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 0 1\n3 0 1 2\n2 0 1\n#' > one.ply
    expect_line stderr 'left out 1 face of' info one.ply
    grep -q 'ignored 1 byte after' .stderr || fail "not 1 byte"
    printf '7' > one.txt
    expect_failure 3 "one.txt: 1 number where" slice one.stl --transform one.txt
}

test_progress() {
    sphere ball.stl
    expect_line stderr 'slicing \[' slice ball.stl --progress always
    grep -q 'slicing' .stdout && fail "the bar is on stdout"
    local stage
    expect 0 slice ball.stl --progress always --weld 0.0001 --fill-rule contours --report report.json -o out.svg
    for stage in reading welding slicing writing ledger certificate crossings; do
        grep -q "$stage \[" .stderr || fail "no bar of $stage"
    done
    for stage in read parse weld bucket sweep contours nesting fill write ledger certificate crossings total report; do
        json_value report.json ms "$stage" > .value || exit 1
    done
    expect_json report.json 0.0 ms fill
    grep -qE '^time .*, crossings [0-9.]+, report [0-9.]+ ' .stdout || fail "no time of the report"
    expect 0 slice ball.stl
    grep -qE '^time .*, nesting [0-9.]+, fill [0-9.]+ ' .stdout || fail "no time of the fill rule"
    rm .value
    expect_line stderr 'checking \[' check ball.stl --progress always
    expect_line stderr 'inspecting \[' info ball.stl --progress always
    expect_silent slice ball.stl --progress auto
    expect_silent slice ball.stl --progress never
}
