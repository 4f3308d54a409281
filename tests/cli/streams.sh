# Tests of standard input and output in place of files, and of several meshes at once; sourced by cli.sh.

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
    expect 0 slice ball.stl -o named.svg --report named.json
    gzip -k ball.stl
    local file
    for file in ball.stl ball.stl.gz; do
        piped 0 "$file" slice - -o piped.svg --report piped.json
        [[ ! -s .stderr ]] || fail "$file: stderr is not silent"
        cmp named.svg piped.svg || fail "$file: another SVG"
        expect_json piped.json - mesh
        expect_json piped.json "$(json_value named.json output_hash)" output_hash
    done
    piped 0 ball.stl slice - --map --report mapped.json
    expect_json mapped.json "$(json_value named.json output_hash)" output_hash
    printf 'OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 1\n3 0 1 2\n' > one.txt
    piped 0 one.txt info -
    grep -q '^mesh  *standard input, text OFF' .stdout || fail "the format is not found by content"
    piped 0 one.txt check -
    grep -q '^mesh  *standard input, text OFF' .stdout || fail "check reads no standard input"
    expect 0 info - < ball.stl
    cp ball.stl ./-
    expect_line stdout '^mesh  *\./-, ' info ./-

    expect_failure 3 "standard input: is empty" info - < /dev/null
    expect_failure 3 "standard input: cannot be read: Is a directory" info - < .
    expect_failure 3 "standard input: cannot be read: Bad file descriptor" info - <&-
    TMPDIR=$PWD expect 0 info - < ball.stl
    (ulimit -f 10; export TMPDIR=$PWD; expect_failure 3 "standard input: cannot be kept in a temporary file in '$PWD': File too large" info - < ball.stl) ||
        exit 1
    expect_failure 2 "'-' is given twice" info - - < ball.stl
    expect_failure 2 "'-' is given twice" check - ball.stl - < ball.stl
    expect_files - ball.stl ball.stl.gz mapped.json named.json named.svg one.txt piped.json piped.svg
}

# Waiting for the other end of a pipe ends with a signal, and leaves no file.
test_waiting_input() {
    mkfifo pipe
    exec 3<> pipe
    local tool
    set -m
    TMPDIR=$PWD "$lamella" slice - < pipe > .stdout 2> .stderr &
    set +m
    tool=$!
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
    grep -q '^wrote  *standard output$' .stderr || fail "no summary on stderr"
    expect_json report.json - output
    "$lamella" make sphere --triangles 1000 --height 20 -o - 2> .stderr | "$lamella" slice - -o - 2>> .stderr > through.svg
    [[ ${PIPESTATUS[*]} == "0 0" ]] || fail "the pipe fails"
    cmp through.svg ball.svg || fail "another SVG through pipes"
    "$lamella" make sphere -o - 2> .stderr | "$lamella" info - > .stdout 2>> .stderr
    grep -q '^triangles  *1,000,000$' .stdout || fail "not the default number of triangles"

    # What a redirected output held stays, and what comes later follows.
    { echo before; "$lamella" slice ball.stl -o - 2> .stderr; echo after; } > around.txt
    cmp <(echo before; cat ball.svg; echo after) around.txt || fail "the output is not where the shell puts it"

    { head -c 80 ball.stl; le32 999; tail -c +85 ball.stl | head -c $((999 * 50)); } > open.stl
    expect 0 check open.stl --marks open.ply
    expect 0 check open.stl --marks -
    cmp .stdout open.ply || fail "other marks"
    grep -q '^not clean: ' .stderr || fail "no words on stderr"

    expect_failure 2 "--report: '-' is --output too" slice ball.stl -o - --report -
    expect_failure 2 "--report: '-' is --marks too" check ball.stl --marks - --report -
    "$lamella" slice ball.stl -o - >&- 2> .stderr
    one_line 4 $? "cannot write to standard output" "closed"
    "$lamella" slice ball.stl -o - > /dev/full 2> .stderr
    one_line 4 $? "No space left" "full"
    expect_files around.txt ball.stl ball.svg open.ply open.stl report.json through.svg
}

# A reader that has seen enough ends what writes to it, soon and by one line.
test_closed_pipe() {
    sphere ball.stl 20000
    local status
    # All of the mesh takes four seconds of the processor.
    (ulimit -t 1; exec "$lamella" make sphere --triangles 100000000 -o - 2> .stderr) | head -c 100 > .stdout
    status=${PIPESTATUS[0]}
    one_line 4 "$status" "Broken pipe" make
    "$lamella" slice ball.stl --layer-height 0.001 -o - 2> .stderr | head -c 100 > .stdout
    status=${PIPESTATUS[0]}
    one_line 4 "$status" "Broken pipe" slice
    { sleep 0.3; "$lamella" info ball.stl ball.stl; echo $? > status; } 2> .stderr | true
    one_line 4 "$(cat status)" "Broken pipe" info
    expect_files ball.stl status
}

test_several() {
    sphere ball.stl
    mkdir -p folder/below folder/.hidden folder/empty
    cp ball.stl folder/c.stl
    cp ball.stl folder/below/B.STL
    gzip -c ball.stl > folder/a.stl.gz
    cp ball.stl folder/.hidden/hidden.stl
    cp ball.stl folder/ball
    ln -s .. folder/up
    echo words > folder/words.txt
    expect 0 info folder ball.stl
    [[ $(sed -n 's/^mesh  *\([^,]*\),.*/\1/p' .stdout | tr '\n' ' ') == "folder/a.stl.gz folder/below/B.STL folder/c.stl ball.stl " ]] ||
        fail "not the meshes, in order"
    (($(grep -c '^$' .stdout) == 3)) || fail "no line between two blocks"
    [[ ! -s .stderr ]] || fail "stderr is not silent"
    expect 0 check ball.stl folder/c.stl --report two.json
    (($(grep -c '^closed and clean$' .stdout) == 2)) || fail "not two verdicts"
    expect_json two.json folder/c.stl 1 mesh
    expect 0 check ball.stl --report one.json
    expect_json one.json ball.stl mesh
    [[ $(json_value two.json 0 verdict) == "$(json_value one.json verdict)" ]] || fail "another verdict of several"
    expect 0 check folder/below --report folder.json
    expect_json folder.json folder/below/B.STL 0 mesh

    mkdir '[old]'
    cp ball.stl '[old]/[a,b].stl'
    expect 0 info '[old]' '[old]/[a,b].stl'
    (($(grep -cF '[old]/[a,b].stl, ' .stdout) == 2)) || fail "names are split"
    rm -r '[old]'

    # What cannot be used is reported, and the rest is done.
    echo junk > folder/b.obj
    expect 3 info missing.stl folder
    (($(grep -c '^closed  *yes$' .stdout) == 3)) || fail "the rest is not done"
    cmp .stderr <(echo "lamella: missing.stl: cannot be opened: No such file or directory"
        echo "lamella: folder/b.obj: is no STL, OBJ, OFF, PLY, VTK, VTP or 3MF file: text that begins with 'junk'"
        echo "lamella: 2 of 5 meshes could not be used") || fail "other lines of what cannot be used"
    expect 3 check folder/b.obj ball.stl --report -
    cp .stdout mixed.json
    expect_json mixed.json folder/b.obj 0 mesh
    json_value mixed.json 0 error | grep -q "begins with 'junk'" || fail "no reason in the report"
    expect_json mixed.json "closed and clean" 1 verdict
    expect_failure 3 "folder/empty: is a folder in which no file is named as a mesh" info folder/empty
    expect_failure 3 "folder: is a directory" slice folder
    expect_failure 2 "--marks: the marks are of one mesh, and 2 are given" check ball.stl ball.stl --marks out.ply
    expect_failure 2 "the mesh itself" check ball.stl folder --report folder/c.stl
    expect_failure 2 "--unit" info ball.stl folder --unit furlong
    rm -r folder
    expect_files ball.stl folder.json mixed.json one.json two.json
}
