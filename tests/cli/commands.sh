# Help, make, reports and the progress bar; sourced by cli.sh.

test_help() {
    local command
    for command in "" slice info check make convert merge verify batch; do
        # shellcheck disable=SC2086
        expect_silent $command --help
    done
    expect_silent --version
    expect 0 slice --help
    tr -s ' \n' ' ' < .stdout | grep -q "end of its name: .svg, .nii.gz, .nii, .seg.nrrd, .nrrd, .dcm, .csv, .jsonl, .png, .h5;" ||
        fail "--help does not list the ends of names"
}

test_make() {
    local shape count
    for shape in sphere torus gyroid bone prism; do
        expect 0 make "$shape" --triangles 20000 -o "$shape.stl"
        expect_line stdout '^closed  *yes' info "$shape.stl"
        count=$(sed -n 's/^triangles *//p' .stdout | tr -d ,)
        ((count >= 19800 && count <= 20200)) || fail "$shape: $count triangles"
        expect 0 make "$shape" --triangles 20000 -o again.stl
        cmp "$shape.stl" again.stl || fail "$shape: another file the second time"
    done
    expect 0 make bone --triangles 20000 --order random -o shuffled.stl
    cmp -s bone.stl shuffled.stl && fail "the order is not random"
    expect 0 slice bone.stl --report sorted.json
    expect 0 slice shuffled.stl --report shuffled.json
    expect_json sorted.json "$(json_value shuffled.json output_hash)" output_hash
}

# A report but for its times, which differ from run to run.
without_times() { sed '/^  "ms": {$/,/^  },\{0,1\}$/d'; }

# What only the tool adds to a report, and what no other test of reports shows.
test_reports() {
    sphere ball.stl
    expect 0 slice ball.stl --layer-height 0.5 -o ball.svg --report -
    cp .stdout report.json
    expect_members report.json triangles=1000 planes=40 contours=40 holes=0 open_contours=0 degenerate=0 \
        mesh=ball.stl output=ball.svg 'plan side=below' 'plan datum=mesh-min' 'plan kind=uniform' 'volume verdict=holds'
    local key
    for key in segments grid_mm threads peak_rss_bytes output_hash "ms read" "ms bucket" "ms sweep" "ms contours" "ms nesting" \
        "ms write" "ms total"; do
        # shellcheck disable=SC2086
        json_value report.json $key > /dev/null || exit 1
    done
    grep -q '^contours  40' .stderr || fail "no summary on stderr"
    [[ $(tail -c 2 report.json | head -c 1) == "}" ]] || fail "something follows the JSON"
    ! command -v xmllint > /dev/null || xmllint --noout --huge ball.svg || fail "not XML"
    { cat ball.stl; printf 'seven more bytes'; } > trailing.stl
    expect 0 slice trailing.stl --report report.json
    json_value report.json warnings 0 | grep -q '16 bytes' || fail "no warning in the report"
    cubes
    expect 0 slice both.stl --layer-height 10 --first-height 5 --report report.json
    expect_members report.json fill_rule=non-zero solid_volume_mm3=1500.0 contours=1 \
        'volume verdict=solid is not what the mesh encloses' 'volume differing_signed_mm2=200.0' 'volume differing_solid_mm2=150.0'
    expect 0 slice pair.stl --planes 5 --report report.json -o pair.csv
    expect_json report.json 1 cancelled_layers
    expect 0 slice pair.stl --planes 5 --orient-shells -o pair.csv
    grep -q '^pair,24,2000,' pair.meshes.csv || fail "the volume is not that of the turned shells"
    expect 0 slice inverted.stl --planes 5,7 --fill-rule positive --drop-collinear --report report.json
    expect_json report.json 2 region emptied_layers
    expect 0 slice cracked.stl --planes 5 --weld 0.01 --report report.json -o out.svg
    expect_members report.json open_contours=0 'weld joined=1' 'weld vertices=8'
    grep -q 'Vertices at most 0.01 mm apart welded before: 1 moved' out.svg || fail "the SVG does not say what was welded"
    tetrahedron wide.obj 1500
    expect 0 slice wide.obj --layer-height 100 --report report.json
    expect_json report.json "the unit doubles beyond 1,024 mm, and parts there change with the plate" grid_rule
}

test_check() {
    sphere ball.stl
    without_last ball.stl > open.stl
    expect 0 check open.stl --report open.json --marks open.ply
    expect_members open.json 'findings boundary_edges count=3' 'findings boundary_loops places 0 edges=3' clean=OFF \
        'file format=STL'
    grep -q '^element vertex 7$' open.ply && grep -q '^element edge 3$' open.ply || fail "marks: not seven points and three edges"
    cp .stdout words
    expect 0 check open.stl --threads 1 --report - --marks again.ply
    cmp <(without_times < .stdout) <(without_times < open.json) || fail "another report on one thread"
    local stage
    for stage in read parse measure faces edges joints shells meeting gaps write total report; do
        json_value open.json ms "$stage" > /dev/null || exit 1
    done
    cmp .stderr words || fail "other words on one thread"
    cmp open.ply again.ply || fail "other marks on one thread"
    expect 0 check open.stl --marks -
    cmp .stdout open.ply || fail "other marks on standard output"
    grep -q '^not clean: ' .stderr || fail "no words on stderr"
    # Of several meshes, and of folders, the report is an array.
    mkdir folder
    cp ball.stl folder/B.STL
    echo junk > folder/c.obj
    expect 3 check ball.stl folder --report several.json
    expect_members several.json '0 mesh=ball.stl' '1 mesh=folder/B.STL' '1 verdict=closed and clean' '2 mesh=folder/c.obj'
    json_value several.json 2 error | grep -q "begins with 'junk'" || fail "no reason in the report"
    (($(grep -c '^closed and clean$' .stdout) == 2)) || fail "not two verdicts"
    expect_files again.ply ball.stl folder folder/B.STL folder/c.obj open.json open.ply open.stl several.json words
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
        json_value report.json ms "$stage" > /dev/null || exit 1
    done
    expect_json report.json 0.0 ms fill
    grep -qE '^time .*, crossings [0-9.]+, report [0-9.]+ ' .stdout || fail "no time of the report"
    expect_line stdout '^time .*, nesting [0-9.]*, fill [0-9.]* ' slice ball.stl
    expect_line stderr 'checking \[' check ball.stl --progress always
    expect_line stderr 'inspecting \[' info ball.stl --progress always
    expect_silent slice ball.stl --progress auto
    expect_silent slice ball.stl --progress never
}
