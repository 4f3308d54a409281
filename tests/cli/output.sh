# Help, the progress bar, and what the tool writes and leaves behind, by files and streams; sourced by cli.sh.

# piped STATUS FILE ARGUMENT...: runs the tool with the file on a pipe to its standard input and requires this exit status.
piped() {
    local status=$1 file=$2
    shift 2
    # shellcheck disable=SC2002
    cat "$file" | "$lamella" "$@" > .stdout 2> .stderr
    ((PIPESTATUS[1] == status)) || fail "lamella $*: not exit status $status"
}

test_standard_input() {
    sphere ball.stl
    expect 0 slice ball.stl -o named.svg --hash
    local hash file
    hash=$(hash_of)
    gzip -k ball.stl
    for file in ball.stl ball.stl.gz; do
        piped 0 "$file" slice - -o piped.svg --report piped.json
        [[ ! -s .stderr ]] || fail "$file: stderr is not silent"
        cmp named.svg piped.svg || fail "$file: another SVG"
        [[ $(members piped.json mesh output_hash) == $'mesh: -\noutput_hash: '"$hash" ]] || fail "$file: another mesh or hash in the report"
    done
    piped 0 ball.stl slice - --map --hash
    [[ $(hash_of) == "$hash" ]] || fail "another hash of a mapped pipe"
    printf 'OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 1\n3 0 1 2\n' > one.txt
    for command in info check; do
        piped 0 one.txt $command -
        grep -q '^mesh  *standard input, text OFF' .stdout || fail "$command: the format is not found by content"
    done
    expect_failure 3 "standard input: cannot be read: Is a directory" info - < .
    expect_failure 3 "standard input: cannot be read: Bad file descriptor" info - <&-
    TMPDIR=$PWD expect 0 info - < ball.stl
    (ulimit -f 10; export TMPDIR=$PWD; expect_failure 3 "standard input: cannot be kept in a temporary file in '$PWD': File too large" info - < ball.stl) ||
        exit 1
    expect_files ball.stl ball.stl.gz named.svg one.txt piped.json piped.svg
}

# Waiting for the other end of a pipe ends with a signal, and leaves no file.
test_waiting_input() {
    mkfifo pipe
    exec 3<> pipe
    local tool
    TMPDIR=$PWD start_tool slice - < pipe
    sleep 0.5
    kill -0 "$tool" || fail "did not wait"
    kill -s INT "$tool"
    wait "$tool" 2> /dev/null
    (($? == 130)) || fail "another exit status"
    expect_files pipe
}

test_standard_output() {
    sphere ball.stl
    expect 0 make sphere --triangles 1000 --height 20 -o -
    cmp .stdout ball.stl || fail "another mesh"
    [[ $(cat .stderr) == "standard output: sphere, 1,000 triangles, "* ]] || fail "no words on stderr"
    expect 0 slice ball.stl -o ball.svg
    expect 0 slice ball.stl -o - --report report.json
    cmp .stdout ball.svg || fail "another SVG"
    grep -q '^wrote  *standard output: 100 layers' .stderr || fail "no summary on stderr"
    [[ $(json_value report.json output) == - ]] || fail "the report names another output"
    "$lamella" make sphere --triangles 1000 --height 20 -o - 2> .stderr | "$lamella" slice - -o - 2>> .stderr > through.svg
    [[ ${PIPESTATUS[*]} == "0 0" ]] || fail "the pipe fails"
    cmp through.svg ball.svg || fail "another SVG through pipes"
    "$lamella" make sphere -o - 2> .stderr | "$lamella" info - > .stdout 2>> .stderr
    grep -q '^triangles  *1,000,000$' .stdout || fail "not the default number of triangles"
    # What a redirected output held stays, and what comes later follows.
    { echo before; "$lamella" slice ball.stl -o - 2> .stderr; echo after; } > around.txt
    cmp <(echo before; cat ball.svg; echo after) around.txt || fail "the output is not where the shell puts it"
    local command
    for command in "slice ball.stl -o -" "slice ball.stl" "info ball.stl" "slice ball.stl --report -"; do
        # shellcheck disable=SC2086
        fails_into 4 "No space left" $command > /dev/full
    done
    fails_into 4 "cannot write to standard output" slice ball.stl -o - >&-
    expect_files around.txt ball.stl ball.svg report.json through.svg
}

# A reader that has seen enough ends what writes to it, soon and by one line.
test_closed_pipe() {
    sphere ball.stl 20000
    # All of the mesh takes four seconds of the processor.
    (ulimit -t 1; fails_into 4 "Broken pipe" make sphere --triangles 100000000 -o -) | head -c 100 > .stdout
    ((PIPESTATUS[0] == 0)) || exit 1
    (fails_into 4 "Broken pipe" slice ball.stl --layer-height 0.001 -o -) | head -c 100 > .stdout
    ((PIPESTATUS[0] == 0)) || exit 1
    (sleep 0.3; fails_into 4 "Broken pipe" info ball.stl ball.stl) | true
    ((PIPESTATUS[0] == 0)) || exit 1
    expect_files ball.stl
}

test_no_partial_output() {
    sphere ball.stl 20000
    echo precious > out.svg
    # A limit on file size behaves like a disk that fills up.
    (ulimit -f 64; expect_failure 4 "out.svg" slice ball.stl -o out.svg) || exit 1
    [[ $(cat out.svg) == precious ]] || fail "the old file is gone"
    (ulimit -f 64; expect_failure 4 "other.stl" make sphere --triangles 20000 -o other.stl) || exit 1
    (ulimit -f 1; expect_failure 4 "report.json" slice ball.stl --report report.json) || exit 1
    expect_files ball.stl out.svg
}

test_help() {
    local command
    for command in "" slice info check make convert merge verify batch; do
        # shellcheck disable=SC2086
        expect_silent $command --help
    done
    expect_silent --version
    expect 0 slice --help
    tr -s ' \n' ' ' < .stdout | grep -q "end of its name: .svg, .cli, .3mf, .dxf, .geojson, .vtp, .sl1, .sl1s, .zip, .nii.gz, .nii, .seg.nrrd, .nrrd, .mha, .seg.dcm, .dcm, .csv, .jsonl, .png, .h5;" ||
        fail "--help does not list the ends of names"
}

# completed WORD...: what bash offers for the last of them.
completed() {
    bash -c 'source completion.bash; COMP_WORDS=("$@") COMP_CWORD=$(($# - 1)); _lamella; echo "${COMPREPLY[*]}"' - "$@"
}

test_manual() {
    expect_silent --completion
    cp .stdout completion.bash
    [[ $(completed lamella sl) == slice ]] || fail "commands are not completed"
    [[ $(completed lamella slice --layer-h) == --layer-height ]] || fail "options are not completed"
    [[ $(completed lamella slice --progress "") == "auto always never" ]] || fail "values are not completed"
    [[ $(completed lamella slice --progress = al) == always ]] || fail "values after = are not completed"
    [[ -z $(completed lamella slice x) ]] || fail "something is offered in place of files"
    expect_silent --man
    local option
    for option in $(completed lamella slice --); do
        grep -qF -- "${option//-/\\-}" .stdout || fail "the manual lacks $option"
    done
    if command -v groff > /dev/null; then
        [[ -z $(groff -man -ww -z < .stdout 2>&1) ]] || fail "the manual page has warnings"
    fi
}

test_quiet() {
    sphere ball.stl
    expect_silent slice --quiet ball.stl
    [[ ! -s .stdout ]] || fail "--quiet says something"
    expect_silent slice --quiet ball.stl -o ball.svg --report ball.json
    [[ ! -s .stdout && -s ball.svg && -s ball.json ]] || fail "--quiet says something, or a file is missing"
    expect 2 slice --quiet --progress always ball.stl
    expect 3 slice --quiet none.stl
    [[ -s .stderr ]] || fail "--quiet hides an error"
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
    for stage in read parse weld bucket sweep contours nesting write ledger certificate crossings total report; do
        json_value report.json ms "$stage" > /dev/null || exit 1
    done
    [[ $(json_value report.json ms fill) == 0.0 ]] || fail "contours are filled"
    grep -qE '^time .*, crossings [0-9.]+, report [0-9.]+ ' .stdout || fail "no time of the report"
    expect_line stdout '^time .*, nesting [0-9.]*, fill [0-9.]* ' slice ball.stl
    expect_line stderr 'checking \[' check ball.stl --progress always
    expect_line stderr 'inspecting \[' info ball.stl --progress always
    expect_silent slice ball.stl --progress auto
    expect_silent slice ball.stl --progress never
}

# A copy of the tool finds the page that is beside it, whose place for meshes is all that matters here.
test_view() {
    local -r name='a"<b>&.stl'
    mkdir -p bin share/lamella
    cp "$lamella" bin/lamella
    "$lamella" make sphere --triangles 500 -o "$name" > /dev/null
    ! bin/lamella view -o page.html 2> .stderr || fail "a page came from nowhere"
    expect_message "view without the page" "tools/view/build.sh"
    printf '<p>\n<!-- meshes -->\n</p>' > share/lamella/view.html
    bin/lamella view -o page.html > .stdout || fail "no empty page"
    [[ $(< page.html) == $'<p>\n\n</p>' ]] || fail "the empty page is another"
    bin/lamella view "$name" "$name" -o page.html > .stdout || fail "no page with meshes"
    [[ $(grep -c 'class="mesh" data-name="a&quot;&lt;b&gt;&amp;.stl">' page.html) == 2 ]] || fail "names are not escaped"
    grep -m1 'class="mesh"' page.html | sed 's/.*class="mesh"[^>]*>\(.*\)<\/script>/\1/' | base64 -d | gunzip | cmp - "$name" || fail "another mesh"
    cp page.html before.html
    echo nonsense > bad.stl
    local got=0
    bin/lamella view "$name" bad.stl -o page.html 2> .stderr || got=$?
    ((got == 3)) || fail "exit status $got of a page with nonsense"
    expect_message "view of nonsense" bad.stl
    cmp page.html before.html || fail "the page before is gone"
    got=0
    bin/lamella view "$name" -o "$name" 2> .stderr || got=$?
    ((got == 2)) || fail "a page in place of its mesh"
    [[ $(find . -name '*page.html*' | wc -l) == 1 ]] || fail "something half-written stays"
}
