# The tests; sourced by cli.sh.

test_usage() {
    sphere ball.stl
    local slice=(slice ball.stl)
    expect_failure 2 "subcommand"
    expect_failure 2 "'shred' is not a command" shred ball.stl
    expect_failure 2 "mesh" slice
    expect_failure 2 "--wings" "${slice[@]}" --wings
    expect_failure 2 "extra" "${slice[@]}" extra
    local height
    for height in 0 -0.1 nan inf; do
        expect_failure 2 "--layer-height" "${slice[@]}" --layer-height "$height"
    done
    expect_failure 2 "--layer-height" "${slice[@]}" --layer-height thin
    expect_failure 2 "--layer-height" "${slice[@]}" --layer-height 0.1 --planes 1
    expect_failure 2 "--first-height" "${slice[@]}" --planes 1 --first-height 0.1
    expect_failure 2 "--first-height" "${slice[@]}" --first-height nan
    expect_failure 2 "--seed" "${slice[@]}" --seed 3
    expect_failure 2 "--random-heights" "${slice[@]}" --random-heights 2:1
    expect_failure 2 "--random-heights" "${slice[@]}" --random-heights 0:1
    expect_failure 2 "--random-heights" "${slice[@]}" --random-heights 1
    expect_failure 2 "--planes" "${slice[@]}" --planes 1,two
    expect_failure 2 "plane" "${slice[@]}" --planes 2,1
    expect_failure 2 "plane" "${slice[@]}" --planes 1,1
    expect_failure 2 "--datum" "${slice[@]}" --datum middle
    expect_failure 2 "--side" "${slice[@]}" --side left
    expect_failure 2 "--grid" "${slice[@]}" --grid 0
    expect_failure 2 "--grid" "${slice[@]}" --grid -1
    expect_failure 2 "--normal" "${slice[@]}" --normal 0,0,0
    expect_failure 2 "--normal" "${slice[@]}" --normal 1,2
    expect_failure 2 "--threads" "${slice[@]}" --threads -1
    expect_failure 2 "--threads" "${slice[@]}" --threads many
    expect_failure 2 "--band" "${slice[@]}" --band -1
    expect_failure 2 "--progress" "${slice[@]}" --progress sometimes
    expect_failure 2 "" "${slice[@]}" --layer-height 1e-7
    local option
    for option in -o --report --planes --transform --normal --random-heights; do
        expect_failure 2 "is empty" "${slice[@]}" "$option" ""
    done
    for option in --report --marks; do
        expect_failure 2 "is empty" check ball.stl "$option" ""
    done
    expect_failure 2 "is empty" make sphere --triangles 1000 -o ""
    expect_failure 2 "--output" make sphere
    local command
    for command in slice info check; do
        expect_failure 2 "mesh: the path is empty" "$command" ""
    done
    expect_failure 3 "a grid unit of 1e-12 mm" "${slice[@]}" --grid 1e-12
    expect_failure 2 "the mesh itself" "${slice[@]}" -o ball.stl
    expect_failure 2 "the mesh itself" "${slice[@]}" --report ./ball.stl
    expect_failure 2 "--output itself" "${slice[@]}" -o a --report a
    expect_failure 2 "cube" make cube --triangles 1000 -o cube.stl
    expect_failure 2 "triangles" make sphere --triangles 1 -o s.stl
    expect_failure 2 "--order" make sphere --triangles 1000 --order up -o s.stl
    expect_failure 2 "--layer-height" make sphere --triangles 1000 --layer-height 0.1 -o s.stl
    expect_files ball.stl
    expect 0 --help
    expect 0 slice --help
    expect 0 --version
}

le32() { printf '%b' "$(printf '\\x%02x\\x%02x\\x%02x\\x%02x' $(($1 & 255)) $(($1 >> 8 & 255)) $(($1 >> 16 & 255)) $(($1 >> 24 & 255)))"; }

# with_count FILE COUNT: prints a binary file with its triangle count replaced
with_count() { head -c 80 "$1"; le32 "$2"; tail -c +85 "$1"; }

# with_float FILE BITS: prints a binary file with the first coordinate of the first triangle replaced
with_float() { head -c 96 "$1"; le32 "$2"; tail -c +101 "$1"; }

facet() { printf 'facet normal 0 0 1\nouter loop\n%sendloop\nendfacet\n' "$1"; }

test_bad_input() {
    sphere ball.stl
    mkdir folder.stl
    : > empty.stl
    head -c 30000 ball.stl > truncated.stl
    with_count ball.stl 4294967295 > huge_count.stl
    with_count ball.stl 0 > zero_count.stl
    head -c 80 ball.stl > header_only.stl
    { head -c 80 ball.stl; le32 0; } > no_triangles.stl
    head -c 5000 /dev/urandom > random.stl
    printf '<!DOCTYPE html>\n<html><body>404 Not Found</body></html>\n' > page.stl
    with_float ball.stl 0x7fc00000 > nan.stl
    with_float ball.stl 0xff800000 > infinite.stl
    with_float ball.stl 0x7f6fffff > far_away.stl
    local v=$'vertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n'
    printf 'solid a\n%s\nendsolid a\n' "$(facet "$v")" | head -c 60 > cut.stl
    printf 'solid a\n%s\nendsolid a\n' "$(facet "${v/1 0 0/1 x 0}")" > number.stl
    printf 'solid a\n%s\nendsolid a\n' "$(facet $'vertex 0 0 0\nvertex 1 0 0\n')" > two.stl
    printf 'solid a\n%s\nendsolid a\n' "$(facet "$v"$'vertex 1 1 0\n')" > four.stl
    printf 'solid a\nendsolid a\n' > no_facets.stl
    local file begin command
    for file in missing.stl *.stl; do
        [[ $file != ball.stl ]] || continue
        for command in slice info check; do
            begin=$(date +%s%N)
            expect_failure 3 "$file" "$command" "$file"
            (($(date +%s%N) - begin < 1000000000)) || [[ $lamella == */asan/* || $lamella == */tsan/* ]] || fail "$file: over a second"
        done
        expect_failure 3 "$file" slice "$file" -o out.svg --report out.json
        [[ ! -e out.svg && ! -e out.json ]] || fail "$file: an output"
    done
}

test_accepted_input() {
    sphere ball.stl
    expect 0 slice ball.stl --report plain.json
    local hash
    hash=$(json_value plain.json output_hash)
    { printf 'solid but binary'; tail -c +17 ball.stl; } > solid.stl
    expect 0 slice solid.stl --report report.json
    expect_json report.json "$hash" output_hash
    { cat ball.stl; printf 'seven more bytes'; } > trailing.stl
    expect 0 slice trailing.stl --report report.json
    expect_json report.json "$hash" output_hash
    json_value report.json warnings 0 | grep -q '16' || fail "no warning in the report"
    grep -q '^lamella: warning: .*16' .stderr || fail "no warning that says how many bytes"
    cp ball.stl $'odd\nname.stl'
    expect 0 slice $'odd\nname.stl' --report report.json
    expect_failure 3 'no?file' info $'no\nfile'
    local format
    for format in --map "--threads 1" "--threads 3" "--threads 64" "--band 1" "--band 7" "--form assembled"; do
        # shellcheck disable=SC2086
        expect 0 slice ball.stl $format --report report.json
        [[ ! -s .stderr ]] || fail "$format: stderr is not silent"
        expect_json report.json "$hash" output_hash
    done
}

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
    expect_json report.json 1000 triangles
    expect_json report.json 40 planes
    expect_json report.json 40 contours
    expect_json report.json 0 holes
    expect_json report.json 0 open_contours
    expect_json report.json 0 degenerate
    expect_json report.json ball.stl mesh
    expect_json report.json ball.svg output
    expect_json report.json below plan side
    expect_json report.json mesh-min plan datum
    expect_json report.json uniform plan kind
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
    expect 0 slice ball.stl --layer-height 0.5 -o ball.svg --report ball.json
    [[ ! -s .stderr ]] || fail "stderr is not silent"
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
    expect 0 slice one.stl --planes 0.5 -o out.svg
    grep -q '^mesh .* 1 triangle, ' .stdout || fail "not 1 triangle"
    grep -q '<title>1 layer</title>' out.svg || fail "not 1 layer"
    grep -q 'Planes: 1 plane at ' out.svg || fail "not 1 plane"
    expect 0 check one.stl
    grep -q ', 1 triangle, triangle 0$' .stdout || fail "check: not 1 triangle"
    printf 'ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 2
property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 0 1\n3 0 1 2\n2 0 1\n#' > one.ply
    expect 0 info one.ply
    grep -q 'left out 1 face of' .stderr || fail "not 1 face"
    grep -q 'ignored 1 byte after' .stderr || fail "not 1 byte"
    printf '7' > one.txt
    expect_failure 3 "one.txt: 1 number where" slice one.stl --transform one.txt
}

test_progress() {
    sphere ball.stl
    expect 0 slice ball.stl --progress always
    grep -q 'slicing \[' .stderr || fail "no bar"
    grep -q 'slicing' .stdout && fail "the bar is on stdout"
    local stage
    expect 0 slice ball.stl --progress always --weld 0.0001 --report report.json -o out.svg
    for stage in reading welding slicing writing ledger certificate crossings; do
        grep -q "$stage \[" .stderr || fail "no bar of $stage"
    done
    for stage in read parse weld bucket sweep contours nesting write ledger certificate crossings total; do
        json_value report.json ms "$stage" > .value || exit 1
    done
    rm .value
    expect 0 check ball.stl --progress always
    grep -q 'checking \[' .stderr || fail "no bar of the check"
    expect 0 info ball.stl --progress always
    grep -q 'inspecting \[' .stderr || fail "no bar of the inspection"
    expect 0 slice ball.stl --progress auto
    [[ ! -s .stderr ]] || fail "a bar where stderr is no terminal"
    expect 0 slice ball.stl --progress never
    [[ ! -s .stderr ]] || fail "a bar that was not wanted"
}

test_no_plane_warning() {
    sphere ball.stl
    expect 0 slice ball.stl --planes 100,101 -o out.svg --report report.json
    [[ $(wc -l < .stderr) == 1 ]] || fail "not one line"
    grep -q '^lamella: warning: no plane meets the mesh' .stderr || fail "no warning"
    expect_json report.json 2 planes
    expect_json report.json 0 segments
    json_value report.json warnings 0 | grep -q 'no plane' || fail "no warning in the report"
    [[ -s out.svg ]] || fail "no SVG"
}

test_planes_file() {
    sphere ball.stl
    printf '# heights\n-5, -2.5\n\n0 2.5 # more\r\n+5\n' > heights.txt
    expect 0 slice ball.stl --planes heights.txt --report file.json
    expect 0 slice ball.stl --planes=-5,-2.5,0,2.5,5 --report list.json
    expect 0 slice ball.stl --planes "-5, -2.5, 0, 2.5, 5" --report spaced.json
    local hash
    hash=$(json_value file.json output_hash)
    expect_json list.json "$hash" output_hash
    expect_json spaced.json "$hash" output_hash
    expect_json file.json 5 planes
    expect_json file.json explicit plan kind
    expect_json file.json below plan side
    expect 0 slice ball.stl --planes heights.txt --side above --report above.json
    expect_json above.json above plan side
    [[ $(json_value above.json output_hash) != "$hash" ]] || fail "--side above cut where below does"
    expect_failure 3 "none.txt" slice ball.stl --planes none.txt
    printf '1\n2\nthree\n' > bad.txt
    expect_failure 3 "bad.txt:3: 'three'" slice ball.stl --planes bad.txt
    printf '1\n\n3 2\n' > order.txt
    expect_failure 3 "order.txt:3" slice ball.stl --planes order.txt
    printf '1\n\0a\x1b%050d\n' 0 > binary.txt
    expect_failure 3 "binary.txt:2: '?a?$(printf %037d 0)...' is not a number" slice ball.stl --planes binary.txt
    expect_failure 3 "binary.txt:2: '?a?$(printf %037d 0)...' is not a number" slice ball.stl --transform binary.txt
    printf '1\n1.0000000001\n' > close.txt
    expect_failure 3 "close.txt:2" slice ball.stl --planes close.txt
    : > none.txt
    expect_failure 3 "none.txt" slice ball.stl --planes none.txt
    expect_failure 3 "Is a directory" slice ball.stl --planes .
}

test_orientation() {
    expect 0 make sphere --triangles 2000 --height 20 --width 10 -o egg.stl
    expect 0 slice egg.stl --layer-height 0.5 --report up.json
    expect_json up.json 40 planes
    expect 0 slice egg.stl --layer-height 0.5 --normal 0,0,3 --report same.json
    expect_json same.json "$(json_value up.json output_hash)" output_hash
    expect 0 slice egg.stl --layer-height 0.5 --normal 1,0,0 --report side.json
    expect_json side.json 20 planes
    printf '1 0 0 0\n0 1 0 0\n0 0 2 0 # twice as tall\n' > tall.txt
    expect 0 slice egg.stl --layer-height 0.5 --transform tall.txt --report tall.json
    expect_json tall.json 80 planes
    expect_json tall.json 2.0 frame 10
    printf '1 0 0 0 0 1 0 0 0 0 2 0 0 0 0 1\n' > square.txt
    expect 0 slice egg.stl --layer-height 0.5 --transform square.txt --report square.json
    expect_json square.json "$(json_value tall.json output_hash)" output_hash
    printf '1 2 3\n' > short.txt
    expect_failure 3 "short.txt: 3 numbers" slice egg.stl --transform short.txt
    printf '1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 2\n' > projective.txt
    expect_failure 3 "projective.txt:4" slice egg.stl --transform projective.txt
    expect_failure 3 "none.txt" slice egg.stl --transform none.txt
    expect_failure 2 "--normal" slice egg.stl --transform tall.txt --normal 1,0,0
}

test_units() {
    expect 0 make sphere --triangles 2000 --height 2 -o ball.stl
    expect 0 slice ball.stl --layer-height 0.5 --unit cm --report cm.json
    expect_json cm.json 40 planes
    expect_json cm.json 10.0 file mm_per_unit
    expect_json cm.json OFF file states_unit
    expect_json cm.json STL file format
    expect_json cm.json "" file patient_frame
    expect 0 slice ball.stl --layer-height 0.5 --unit 10 --report ten.json
    expect_json ten.json "$(json_value cm.json output_hash)" output_hash
    printf '10 0 0 0 0 10 0 0 0 0 10 0\n' > ten.txt
    expect 0 slice ball.stl --layer-height 0.5 --transform ten.txt --report moved.json
    expect_json moved.json "$(json_value cm.json output_hash)" output_hash
    expect 0 info ball.stl --unit in
    grep -q 'units of 25.4 mm' .stdout || fail "info does not say the unit"
    expect_failure 2 "--unit" slice ball.stl --unit furlong
    expect_failure 2 "--unit" slice ball.stl --unit -1
    (printf '3D Slicer output. SPACE=RAS' | head -c 80; head -c 53 /dev/zero; tail -c +81 ball.stl) > ras.stl
    expect 0 slice ras.stl --layer-height 0.5 --report ras.json
    expect_json ras.json RAS file patient_frame
    grep -q 'patient frame RAS' .stdout || fail "the summary does not say the frame"
    gzip -k ras.stl
    expect 0 slice ras.stl.gz --layer-height 0.5 --report zipped.json
    expect_json zipped.json "$(json_value ras.json output_hash)" output_hash
    expect_json zipped.json ON file compressed
}

# cube FILE X SIDES: writes an ASCII cube of 10 mm at x with the first SIDES of its six sides
cube() {
    local x0=$2 x1=$(($2 + 10)) sides=$3
    local a="$x0 0 0" b="$x1 0 0" c="$x1 10 0" d="$x0 10 0" e="$x0 0 10" f="$x1 0 10" g="$x1 10 10" h="$x0 10 10"
    local corners=("$a|$d|$c" "$a|$c|$b" "$e|$f|$g" "$e|$g|$h" "$b|$c|$g" "$b|$g|$f" "$c|$d|$h" "$c|$h|$g" "$d|$a|$e" "$d|$e|$h"
        "$a|$b|$f" "$a|$f|$e") i
    {
        echo solid
        for ((i = 0; i < 2 * sides; ++i)); do
            facet "$(tr '|' '\n' <<< "${corners[i]}" | sed 's/^/vertex /')"$'\n'
        done
        echo endsolid
    } > "$1"
}

test_mending() {
    cube left.stl 0 6
    cube right.stl 5 6
    cat left.stl right.stl > both.stl
    local rule
    for rule in contours even-odd non-zero positive; do
        expect 0 slice both.stl --planes 5 --fill-rule "$rule" -o out.svg --report report.json
        expect_json report.json "$rule" fill_rule
        grep -q "Fill rule $rule" out.svg || fail "the SVG does not say the rule"
    done
    expect 0 slice both.stl --layer-height 10 --first-height 5 --fill-rule non-zero --report report.json
    expect_json report.json 1500.0 solid_volume_mm3
    expect_json report.json 1 contours
    grep -q 'rule non-zero' .stdout || fail "the summary does not say the rule"
    expect_failure 2 "--fill-rule" slice both.stl --fill-rule odd
    expect_json report.json "contours not as walked" volume verdict

    sed -E 's/^vertex ([0-9]+) 0 /vertex \1 5 /; s/^vertex ([0-9]+) 10 /vertex \1 15 /' right.stl > shifted.stl
    cat left.stl shifted.stl > through.stl
    expect 0 slice through.stl --planes 5 --report through.json
    expect_json through.json 2 crossings count
    expect_json through.json 5.0 crossings layers 0 first_mm 0
    expect_json through.json 10.0 crossings layers 0 first_mm 1
    expect_json through.json 2000.0 volume mesh_mm3
    expect_json through.json holds volume verdict
    grep -q '^crossings 2 of contours, in layers 1' .stdout || fail "the summary does not say what crosses"

    cube open.stl 0 5
    expect 0 slice open.stl --planes 5 --report open.json
    expect_json open.json 1 open_contours
    expect_json open.json 5.0 open_layers 0 plane_mm
    expect_json open.json 1 open_layers 0 count
    expect_json open.json 10.0 open_layers 0 first 0 gap_mm
    expect_json open.json 0 open_layers 0 not_listed
    expect_json open.json 10 ledger triangles
    expect_json open.json 6 ledger cut
    expect_json open.json 4 ledger between_planes
    expect_json open.json 100.0 ledger flat_up_mm2
    expect_json open.json "open mesh" volume verdict
    grep -q '^volume *not certified: open mesh' .stdout || fail "an open mesh has a volume"
    expect 0 slice open.stl --planes 5 --close-gaps 9.5 --report report.json
    expect_json report.json 1 open_contours
    expect_json report.json 0 gaps closed
    expect 0 slice open.stl --planes 5 --close-gaps 10 --report report.json
    expect_json report.json 0 open_contours
    expect_json report.json 1 gaps closed
    expect_json report.json 10.0 gaps total_mm
    expect_json report.json 10.0 gaps closings 0 length_mm
    grep -q '^gaps *1 closed' .stdout || fail "the summary does not say what was closed"
    expect_failure 2 "--close-gaps" slice open.stl --close-gaps -1

    awk '/^vertex 10 10 10$/ && ++n == 3 {$2 = 10.001} 1' left.stl > cracked.stl
    expect 0 slice cracked.stl --planes 5 --report report.json
    expect_json report.json 2 open_contours
    expect 0 slice cracked.stl --planes 5 --weld 0.01 --report report.json
    expect_json report.json 0 open_contours
    expect_json report.json 1 weld joined
    expect_json report.json 8 weld vertices
    grep -q '^welded *1 vertex onto' .stdout || fail "the summary does not say what was welded"
    expect 0 slice cracked.stl --planes 5 --weld 0.01 -o out.svg
    grep -q 'Vertices at most 0.01 mm apart welded before: 1 moved' out.svg || fail "the SVG does not say what was welded"
    expect 0 slice left.stl --planes 5 --weld 0 -o out.svg
    grep -q 'Vertices at most 0 mm apart welded before: 0 moved' out.svg || fail "the SVG does not say that nothing moved"
    expect 0 slice left.stl --planes 5 -o out.svg
    grep -q 'weld' out.svg && fail "the SVG speaks of welding"
    expect_failure 3 "left.stl: welding at 20 mm leaves nothing: each of 12 triangles has two equal corners" \
        slice left.stl --planes 5 --weld 20
    expect_failure 2 "--weld" slice cracked.stl --weld nan
}

test_make() {
    local shape
    for shape in sphere torus gyroid bone prism; do
        expect 0 make "$shape" --triangles 20000 -o "$shape.stl"
        expect 0 info "$shape.stl"
        grep -q '^closed  *yes' .stdout || fail "$shape is not closed"
        local count
        count=$(sed -n 's/^triangles *//p' .stdout | tr -d ,)
        ((count >= 19800 && count <= 20200)) || fail "$shape: $count triangles"
        expect 0 make "$shape" --triangles 20000 -o again.stl
        cmp "$shape.stl" again.stl || fail "$shape: another file the second time"
        rm again.stl
    done
    expect 0 make bone --triangles 20000 --order random --seed 7 -o shuffled.stl
    cmp -s bone.stl shuffled.stl && fail "the order is not random"
    expect 0 slice bone.stl --report sorted.json
    expect 0 slice shuffled.stl --report shuffled.json
}

test_info() {
    sphere ball.stl
    expect 0 info ball.stl
    local line
    for line in 'triangles  *1,000' 'degenerate  *0' 'boundary edges  *0' 'over-full edges  *0' 'shells  *1' 'closed  *yes'; do
        grep -qE "^$line\$" .stdout || fail "no line '$line'"
    done
    grep -qE '^box  *x .* to .*, y .* to .*, z -?[0-9.e-]+ to ' .stdout || fail "no box"
    [[ ! -s .stderr ]] || fail "stderr is not silent"
    # One triangle fewer leaves a hole with three edges.
    { head -c 80 ball.stl; le32 999; tail -c +85 ball.stl | head -c $((999 * 50)); } > open.stl
    expect 0 info open.stl
    grep -qE '^boundary edges  *3$' .stdout || fail "the hole is not seen"
    grep -qE '^closed  *no$' .stdout || fail "an open mesh is called closed"
    expect 0 slice open.stl --report open.json
}

# A report but for its times, which differ from run to run.
without_times() { sed '/^  "ms": {$/,/^  },\{0,1\}$/d'; }

test_check() {
    sphere ball.stl
    expect 0 check ball.stl
    [[ $(tail -n 1 .stdout) == "closed and clean" ]] || fail "the last line is not the verdict"
    [[ ! -s .stderr ]] || fail "stderr is not silent"
    { head -c 80 ball.stl; le32 999; tail -c +85 ball.stl | head -c $((999 * 50)); } > open.stl
    expect 0 check open.stl --report open.json --marks open.ply
    [[ $(tail -n 1 .stdout) == "not clean: 3 boundary edges, 1 boundary loop" ]] || fail "the hole is not named"
    grep -qE '^boundary edges  *3$' .stdout || fail "no count"
    grep -qE '^  \(.*\) \(.*\), triangle [0-9]+$' .stdout || fail "no place"
    expect_json open.json 3 findings boundary_edges count
    expect_json open.json 3 findings boundary_loops places 0 edges
    expect_json open.json OFF clean
    expect_json open.json STL file format
    grep -q '^element vertex 7$' open.ply || fail "marks: not seven points"
    grep -q '^element edge 3$' open.ply || fail "marks: not three edges"
    cp .stdout words
    expect 0 check open.stl --threads 1 --report - --marks again.ply
    cmp <(without_times < .stdout) <(without_times < open.json) || fail "another report on one thread"
    local stage
    for stage in read parse measure faces edges joints shells meeting gaps write total; do
        json_value open.json ms "$stage" > .value || exit 1
    done
    rm .value
    cmp .stderr words || fail "other words on one thread"
    cmp open.ply again.ply || fail "other marks on one thread"
    grep -qE '^self-|^duplicate|^cracks' words && fail "kinds that were not found are listed"
    [[ $(sed -n 2p words) =~ ^boundary\ edges\ +3$ ]] || fail "what was found does not come first"
    expect 0 check open.stl --all
    grep -qE '^cracks  *0$' .stdout || fail "--all leaves kinds out"
    expect 0 check open.stl --places 1 --tolerance 0
    grep -q '^  ... and 2 more$' .stdout || fail "more than one place"
    expect 0 check ball.stl --unit cm --report cm.json
    expect_json cm.json ON clean
    rm again.ply words
    expect_failure 2 "--tolerance" check ball.stl --tolerance -1
    expect_failure 2 "--tolerance" check ball.stl --tolerance nan
    expect_failure 2 "--places" check ball.stl --places -1
    expect_failure 2 "--unit" check ball.stl --unit furlong
    expect_failure 2 "the mesh itself" check ball.stl --marks ball.stl
    expect_failure 2 "--marks itself" check ball.stl --marks a --report a
    expect_failure 3 "none.stl" check none.stl
    expect_failure 4 "none/marks.ply" check ball.stl --marks none/marks.ply
    expect_failure 4 "No space left" check ball.stl --report /dev/full
    expect_files ball.stl cm.json open.json open.ply open.stl
}
