# Tests of meshes whose size, place or unit is doubtful; sourced by cli.sh.

# tetrahedron FILE EDGE [X]: an OBJ file; its first corner lies at (X, 0, 0).
tetrahedron() {
    awk -v e="$2" -v x="${3:-0}" 'BEGIN {
        OFMT = CONVFMT = "%.17g"
        print "v", x, 0, 0; print "v", x + e, 0, 0; print "v", x, e, 0; print "v", x, 0, e
        print "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4" }' > "$1"
}

test_scale() {
    # Metres and micrometres are proposed where neither the file nor the user states a unit.
    tetrahedron small.obj 0.0125
    expect_line stderr 'small.obj: the mesh is 0.0125000 mm high, less than a layer: in metres? --unit m$' slice small.obj
    expect_line stderr 'in metres? --unit m$' info small.obj
    grep -qE '^size  *0.0125000 x 0.0125000 x 0.0125000 mm$' .stdout || fail "no size"
    grep -qE '^layers  *0 of 0.1 mm, 0 of 0.2 mm$' .stdout || fail "no number of layers"
    grep -qE '^volume  *0.000000325521 mm3$' .stdout || fail "too few digits"
    expect_line stderr 'in metres? --unit m$' check small.obj
    grep -qE ' solid, depth 0, 4 triangles, 0.000000325580 mm3,' .stdout || fail "too few digits in check"
    expect_line stderr 'in metres? --unit m$' slice small.obj --planes 0.001,1,2
    expect_silent slice small.obj --planes 0.001,0.005 --grid finest
    tetrahedron plate.obj 50
    expect_silent slice plate.obj --layer-height 100
    expect_silent slice small.obj --unit m
    tetrahedron large.obj 25000
    expect_line stderr 'large.obj: the mesh is 25000.000 mm long: in micrometres? --unit um$' slice large.obj --layer-height 1000
    expect_silent info large.obj --unit um
    grep -qE '^layers  *250 of 0.1 mm, 125 of 0.2 mm$' .stdout || fail "the layers are not counted"

    # A finer grid is offered, and taken.
    expect 0 slice small.obj --unit mm --layer-height 0.002 --report coarse.json
    grep -q 'small.obj: the grid of 9.5367431640625e-07 mm is coarse for a mesh of 0.0216506 mm from corner to corner; --grid finest takes' .stderr ||
        fail "a coarse grid is not doubted"
    json_value coarse.json warnings 0 | grep -q 'is coarse for a mesh' || fail "no warning in the report"
    expect_silent slice small.obj --unit mm --layer-height 0.002 --grid finest --report fine.json
    expect_json fine.json 1.4551915228366852e-11 grid_mm
    local command
    for command in slice info check; do
        expect_failure 2 "--grid: 'fine' is neither a number of mm that is at least 0 nor finest" "$command" small.obj --grid fine
        expect 0 "$command" small.obj --unit mm --grid finest
        grep -q coarse .stderr && fail "$command: the finest grid is doubted"
    done
    expect 0 info small.obj --grid finest
    grep -qE '^grid  *1.4551915228366852e-11 mm$' .stdout || fail "info takes another grid"

    # Coordinates that were rounded before they were read.
    tetrahedron away.obj 20 5000
    expect_silent info away.obj
    tetrahedron beyond.obj 2 5000
    expect 0 info beyond.obj
    grep -q 'beyond.obj: the grid of 7.62939453125e-06 mm is coarse .*; none finer reaches the coordinate of 5002.000 mm' .stderr ||
        fail "a grid without a finer one is not doubted"
    expect 0 convert away.obj -o away.stl
    expect_silent slice away.stl
    expect 0 slice away.stl --layer-height 0.004
    grep -q 'away.stl: coordinates of up to 5020.000 mm are stored in steps of 0.000488281 mm, more than a tenth of 0.004 mm' .stderr ||
        fail "lost precision is not reported"
    expect_line stderr 'more than a tenth of 0.004 mm, the layer height or voxel' slice away.stl --spacing 0.004,10,10 --frame lps
    printf '1 0 0 5000 0 1 0 0 0 0 1 0' > move.txt
    tetrahedron here.obj 20
    printf '1 0 0 0\n0 1 0 0\n0 0 0 0\n' > flat.txt
    expect_failure 3 "flat.txt: the matrix is singular: its determinant is 0, so that it flattens every mesh" slice here.obj --transform flat.txt
    expect_silent slice here.obj --transform move.txt

    # The finest grid leaves room for what rules move; of a mesh beyond 1,024 mm the report says what becomes of the grid.
    tetrahedron edge.obj 0.9995
    expect 0 slice edge.obj --grid finest --fill-rule non-zero --offset 0.002 --report grown.json
    expect_json grown.json 1.862645149230957e-09 grid_mm
    tetrahedron wide.obj 1500
    expect 0 slice wide.obj --layer-height 100 --report wide.json
    expect_json wide.json "the unit doubles beyond 1,024 mm, and parts there change with the plate" grid_rule
    grep -q grid_rule grown.json && fail "a rule of the grid that does not apply"

    # Nothing is left where every face collapses.
    tetrahedron speck.obj 1e-9
    expect_failure 3 "speck.obj: each of 4 triangles has two equal corners on the grid" slice speck.obj
    expect_failure 3 "speck.obj: each of 4 triangles has two equal corners on the grid" info speck.obj
    expect_failure 3 "speck.obj: each of 4 triangles has two equal corners on the grid" check speck.obj
    expect 0 slice speck.obj --grid finest --planes 3e-10 --report speck.json
    expect_json speck.json 1 contours

    # An extension that nothing writes.
    expect_failure 2 "no format that is written ends in .pdf; there is .svg, .nii" slice large.obj -o out.pdf
    expect_failure 2 "no format that is written ends in .stl; there is .ply" check large.obj --marks out.stl
    expect_failure 2 "no format that is written ends in .svg; there is .stl" make sphere --triangles 100 -o out.svg
    expect_files away.obj away.stl beyond.obj coarse.json edge.obj fine.json flat.txt grown.json here.obj large.obj move.txt plate.obj small.obj \
        speck.json speck.obj wide.json wide.obj
}
