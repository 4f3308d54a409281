# What the options of slicing do; sourced by cli.sh.

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
    expect_members file.json planes=5 'plan kind=explicit' 'plan side=below'
    expect 0 slice ball.stl --planes heights.txt --side above --report above.json
    expect_json above.json above plan side
    [[ $(json_value above.json output_hash) != "$hash" ]] || fail "--side above cut where below does"
    # As spreadsheets write them: a byte order mark, semicolons or tabs, decimal commas.
    printf '\xef\xbb\xbf-5;-2,5;0\r\n2,5;5;\r\n' > heights.csv
    printf -- '-5\t-2,5\t0\n2,5\t5\n' > heights.tsv
    local file
    for file in heights.csv heights.tsv; do
        expect 0 slice ball.stl --planes $file --report file.json
        expect_json file.json "$hash" output_hash
    done
    printf '0,5\n1,5\n' > either.txt
    expect_failure 3 "either.txt:1: '0,5' is one number or two: write" slice ball.stl --planes either.txt
    printf '0,5;1.5\n' > either.txt
    expect_failure 3 "either.txt:1: '0,5' is one number or two: write" slice ball.stl --planes either.txt
    printf '\xff\xfe1\0\n\0' > wide.txt
    expect_failure 3 "wide.txt: is text in UTF-16: save it as UTF-8" slice ball.stl --planes wide.txt
    printf '\xef\xbb\xbf1 0 0 0\n0 1 0 0\n0 0 1 0\n' > same.txt
    expect 0 slice ball.stl --transform same.txt --planes heights.csv --report file.json
    expect_json file.json "$hash" output_hash
    expect_failure 3 "none.txt" slice ball.stl --planes none.txt
    printf '1\n2\nthree\n' > bad.txt
    expect_failure 3 "bad.txt:3: 'three'" slice ball.stl --planes bad.txt
    printf '2.5 -2.5\n5\n0 -5 2.5\n-5.0000000001\n' > order.txt
    expect 0 slice ball.stl --planes order.txt --report order.json
    expect_json order.json "$hash" output_hash
    expect_json order.json 5 planes
    expect_json order.json 7 plan heights
    printf '1\n\0a\x1b%050d\n' 0 > binary.txt
    expect_failure 3 "binary.txt:2: '?a?$(printf %037d 0)...' is not a number" slice ball.stl --planes binary.txt
    expect_failure 3 "binary.txt:2: '?a?$(printf %037d 0)...' is not a number" slice ball.stl --transform binary.txt
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
    expect_members cm.json planes=40 'file mm_per_unit=10.0' 'file states_unit=OFF' 'file format=STL' \
        'file patient_frame='
    expect 0 slice ball.stl --layer-height 0.5 --unit 10 --report ten.json
    expect_json ten.json "$(json_value cm.json output_hash)" output_hash
    printf '10 0 0 0 0 10 0 0 0 0 10 0\n' > ten.txt
    expect 0 slice ball.stl --layer-height 0.5 --transform ten.txt --report moved.json
    expect_json moved.json "$(json_value cm.json output_hash)" output_hash
    expect_line stdout 'units of 25.4 mm' info ball.stl --unit in
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

test_simplify() {
    cube cube.stl 0 6
    expect 0 slice cube.stl --planes 2 --simplify 0.01 -o out.svg --report report.json
    expect_json report.json 0.01 region simplify_mm
    expect_json report.json 4 points
    grep -qxF 'dropped   points within 0.01 mm of the lines left' .stdout || fail "the summary does not say what was dropped"
    grep -qF 'Contours simplified by at most 0.01 mm' out.svg || fail "the SVG does not say what was dropped"
    expect_failure 2 "--simplify: '-1' is not a number of mm that is at least 0" slice cube.stl --simplify -1
}

test_regions() {
    cube left.stl 0 6
    cube right.stl 5 6
    cat left.stl right.stl > both.stl
    expect 0 slice both.stl --planes 2,5 --fill-rule non-zero --fill-from 1:positive --fill-from 40:even-odd --closing 0.5 \
        --offset -1 --miter-limit 2.5 --drop-collinear --largest-only --flag-closing 0.25 -o out.svg --report report.json
    expect_members report.json 'region fill_from 0 first_layer=1' 'region fill_from 0 fill_rule=positive' \
        'region fill_from 1 fill_rule=even-odd' 'region closing_mm=0.5' 'region offset_mm=-1.0' \
        'region miter_limit=2.5' 'region largest_only=ON' 'region drop_collinear=ON' 'region flag_closing_mm=0.25'
    local line
    for line in 'near      0 contours would change if gaps under 0.5 mm were closed' \
        'filled    by the rule non-zero, from layer 1 on positive, from layer 40 on even-odd' 'closed    gaps under 1 mm' \
        'offset    shrunk by 1 mm, miter limit 2.5' 'kept      the largest contour of each layer, with its holes' \
        'dropped   points within straight lines'; do
        grep -qxF "$line" .stdout || fail "the summary does not say '$line'"
    done
    grep -qF 'Fill rule non-zero, from layer 1 on positive, from layer 40 on even-odd. Regions closed by 0.5 mm. Regions shrunk by 1 mm, miter limit 2.5. Only the largest' \
        out.svg || fail "the SVG does not say the rules"

    cube open.stl 0 5
    expect 0 slice open.stl --planes 5 --fill-rule non-zero --stitch 0
    grep -qF 'open      1 of 1 layer (100 % of the height) has open contours' .stdout || fail "no word of the open polyline"

    awk '/vertex/ { v[n++] = $0; if (n == 3) { print v[0]; print v[2]; print v[1]; n = 0 } next } { print }' left.stl > inverted.stl
    expect 0 slice inverted.stl --planes 5,7 --fill-rule positive --drop-collinear --report report.json
    grep -qx 'emptied   all 2 layers that the mesh crosses' .stdout || fail "the summary does not say that nothing is left"
    grep -qF 'the fill rule leaves nothing: all 2 layers that the mesh crosses are empty' .stderr || fail "no warning that nothing is left"
    expect_json report.json 2 region emptied_layers

    expect_failure 2 "--closing: '-1' is not a number of mm that is at least 0" slice both.stl --fill-rule non-zero --closing -1
    expect_failure 2 "--offset: 'inf' is not a number of mm" slice both.stl --fill-rule non-zero --offset inf
    expect_failure 2 "is at most" slice both.stl --fill-rule non-zero --offset 1e6
    expect_failure 2 "nothing would happen" slice both.stl --fill-rule non-zero --closing 1e-9
    expect_failure 2 "--miter-limit: '0.5' is not a number that is at least 1" slice both.stl --fill-rule non-zero --miter-limit 0.5
    expect_failure 2 "needs a region, but layer 0" slice both.stl --closing 1 --fill-rule contours
    expect_failure 2 "needs a region, but layer 7" slice both.stl --largest-only --fill-rule positive --fill-from 7:contours
    expect_failure 2 "in ascending order" slice both.stl --fill-from 7:contours --fill-from 2:positive
    for line in positive 3 3: :positive -3:positive 3.5:positive 3:odd 99999999999999999999:positive; do
        expect_failure 2 "'$line' is not LAYER:RULE" slice both.stl "--fill-from=$line"
    done
    # One value each, so that what follows is the mesh.
    expect 0 slice --fill-from 1:positive both.stl --planes 5
}

test_mending() {
    cube left.stl 0 6
    cube right.stl 5 6
    cat left.stl right.stl > both.stl
    local rule
    for rule in contours even-odd non-zero positive outermost; do
        expect 0 slice both.stl --planes 5 --fill-rule "$rule" -o out.svg --report report.json
        expect_json report.json "$rule" fill_rule
        grep -q "Fill rule $rule" out.svg || fail "the SVG does not say the rule"
    done
    expect 0 slice both.stl --layer-height 10 --first-height 5 --fill-rule non-zero --report report.json
    grep -v '^time\|^memory' .stdout > united
    expect_json report.json 1500.0 solid_volume_mm3
    expect_json report.json 1 contours
    grep -q 'rule non-zero' .stdout || fail "the summary does not say the rule"
    expect_failure 2 "--fill-rule" slice both.stl --fill-rule odd
    grep -q '"region"' report.json && fail "a region's report without more than a fill rule"
    expect_members report.json 'volume verdict=solid is not what the mesh encloses' \
        'volume differing_signed_mm2=200.0' 'volume differing_solid_mm2=150.0'
    expect 0 slice both.stl --layer-height 10 --first-height 5 --report report.json
    grep -v '^time\|^memory' .stdout | diff united - || fail "non-zero is not the default"

    sed -E 's/^vertex ([0-9]+) 0 /vertex \1 5 /; s/^vertex ([0-9]+) 10 /vertex \1 15 /' right.stl > shifted.stl
    cat left.stl shifted.stl > through.stl
    expect 0 slice through.stl --planes 5 --fill-rule contours --report through.json
    expect_members through.json 'crossings count=2' 'crossings layers 0 first_mm 0=5.0' \
        'crossings layers 0 first_mm 1=10.0' 'volume mesh_mm3=2000.0' 'volume verdict=holds'
    grep -q '^crossings 2 of contours, in layers 1' .stdout || fail "the summary does not say what crosses"

    awk '/vertex/ { v[n++] = $0; if (n == 3) { print v[0]; print v[2]; print v[1]; n = 0 } next } { print }' right.stl |
        cat left.stl - > pair.stl
    expect 0 slice pair.stl --planes 5 --report pair.json
    expect_json pair.json 1 cancelled_layers
    grep -qF 'in 1 layer shells turned inwards overlap others, and where they do, both cancel' .stderr || fail "no word of missing solid"
    expect 0 slice pair.stl --planes 5 --orient-shells --report pair.json -o pair.csv
    expect_json pair.json 150.0 volume differing_solid_mm2
    grep -qx 'oriented  1 shell turned, of 2' .stdout || fail "the summary does not say what was turned"
    [[ -s .stderr ]] && fail "a warning of shells that were turned"
    grep -q '^pair,24,2000,' pair.meshes.csv || fail "the volume is not that of the turned shells"

    cube open.stl 0 5
    expect 0 slice open.stl --planes 5 --report open.json
    expect_members open.json open_contours=1 'open_layers 0 plane_mm=5.0' 'open_layers 0 count=1' \
        'open_layers 0 first 0 gap_mm=10.0' 'open_layers 0 not_listed=0' 'ledger triangles=10' 'ledger cut=6' \
        'ledger between_planes=4' 'ledger flat_up_mm2=100.0' 'volume verdict=open mesh'
    grep -q '^volume *not certified: open mesh' .stdout || fail "an open mesh has a volume"
    expect_json open.json 1 open layers
    expect_json open.json 1.0 open height_share
    grep -q '"solid_volume_mm3": null' open.json || fail "a volume of layers whose area is not known"
    expect 0 slice open.stl --planes 5 --stitch 9.5 --report report.json
    expect_json report.json 1 open_contours
    expect_json report.json 0 gaps closed
    expect 0 slice open.stl --planes 5 --stitch 10 --report report.json
    expect_members report.json open_contours=0 'gaps closed=1' 'gaps total_mm=10.0' 'gaps closings 0 length_mm=10.0'
    grep -q '^gaps *1 closed' .stdout || fail "the summary does not say what was closed"
    expect_failure 2 "--stitch" slice open.stl --stitch -1

    # Two opposite walls, 10 mm long and 8 mm apart, one of them flipped: ends face ends.
    cube whole.stl 0 6
    awk '/outer loop/ {n++; k = 0} /^facet/ {m++} m == 7 || m == 8 {if (/vertex/) {
            if (++k == 1) {first = $0} else if (k == 2) {second = $0} else {print $0; print second; print first}
            next} print; next} m < 11 && m > 0 {next} 1' whole.stl |
        awk '$1 == "vertex" && $3 == 10 {$3 = 8} 1' > mixed.stl
    expect 0 slice mixed.stl --planes 5 --stitch 8 --report report.json
    expect_json report.json oriented gaps direction
    expect_json report.json 0 gaps closed
    expect 0 slice mixed.stl --planes 5 --stitch 8 --stitch-direction any --report report.json
    expect_members report.json 'gaps direction=any' 'gaps closed=2' open_contours=0
    expect_failure 2 "--stitch-direction" slice mixed.stl --stitch 8 --stitch-direction both

    awk '/^vertex 10 10 10$/ && ++n == 3 {$2 = 10.001} 1' left.stl > cracked.stl
    expect 0 slice cracked.stl --planes 5 --stitch 0 --report report.json
    expect_json report.json 2 open_contours
    for words in "" "--stitch auto"; do
        expect 0 slice cracked.stl --planes 5 $words --report report.json -o out.svg
        expect_members report.json open_contours=0 'gaps reach_mm=0.17321085678674045' 'gaps closed=2'
        grep -q '<desc>2 gaps of at most' out.svg || fail "the SVG does not show the gap that was closed"
    done
    expect_failure 2 "--stitch: 'car' is neither a number of mm" slice cracked.stl --stitch car
    "$lamella" convert cracked.stl -o cracked.ply > /dev/null 2>&1 || fail "no PLY"
    expect 0 slice cracked.ply --planes 2,5,8 -o whole.svg
    expect 0 slice cracked.ply --planes 2,5,8 --memory 5M -o ranges.svg
    cmp whole.svg ranges.svg || fail "--memory closes other gaps"
    expect 0 slice cracked.stl --planes 5 --weld 0.01 --report report.json
    expect_members report.json open_contours=0 'weld joined=1' 'weld vertices=8'
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
