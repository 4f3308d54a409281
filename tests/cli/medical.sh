# Results that medicine reads. Sourced by cli.sh.

test_masks() {
    sphere a.stl 2000
    sphere b.stl 500
    expect 0 slice a.stl b.stl --spacing 1,1.5,2 --frame ras -o m.nii.gz -o m.nii -o m.seg.nrrd --threads 1
    expect_files a.stl b.stl m.labels.csv m.nii m.nii.gz m.nii.gz.lamella.json m.nii.lamella.json m.seg.nrrd m.seg.nrrd.lamella.json
    grep -q "voxels lie in several meshes" .stderr || fail "overlap is not warned of"
    zcat m.nii.gz | cmp - m.nii || fail "the compressed mask differs"
    cp m.nii.gz one.nii.gz
    expect 0 slice a.stl b.stl --spacing 1,1.5,2 --frame ras -o m --to nii.gz --threads 3
    cmp m.nii.gz one.nii.gz || fail "bytes depend on threads"
    expect_json m.nii.gz.lamella.json RAS patient_frame
    expect_json m.nii.gz.lamella.json "$(sha256sum m.nii.gz | cut -d' ' -f1)" output sha256
    expect_json m.nii.gz.lamella.json "$(sha256sum b.stl | cut -d' ' -f1)" inputs 1 sha256
    # The image that was written gives the same slices again.
    expect 0 slice a.stl b.stl --like m.nii.gz --frame ras -o like.nii
    cmp like.nii m.nii || fail "--like differs from --spacing"
}

test_structure_sets() {
    sphere a.stl 2000
    expect_dicom slice a.stl --spacing 2,2,2 --frame lps --without-ct -o a.dcm || skip "no DICOM"
    local date
    for date in x -5 253402300800 99999999999999999999; do
        SOURCE_DATE_EPOCH=$date expect_failure 2 "SOURCE_DATE_EPOCH: '$date' is not" slice a.stl --spacing 2,2,2 --frame lps --without-ct -o b.dcm
    done
    SOURCE_DATE_EPOCH=253402300799 expect 0 slice a.stl --spacing 2,2,2 --frame lps --without-ct -o b.dcm
    grep -q 99991231 b.dcm || fail "the date is not in the structure set"
    # Of a mesh that encloses nothing there is no ROI.
    open_triangle open.stl
    expect 3 slice open.stl --spacing 1,1,1 --frame ras --without-ct --stitch 0 -o c.dcm
    grep -q "'open' has no closed contour on any slice" .stderr || fail "no word of the ROI that is missing"
    [[ ! -e c.dcm ]] || fail "a structure set of nothing"
    # Other outputs are written, whatever their order.
    expect 3 slice open.stl --spacing 1,1,1 --frame ras --without-ct -o c.csv -o c.dcm -o c.nii
    [[ $(tail -1 .stderr) == "lamella: "*"'open' has no closed contour"* ]] || fail "the last line does not name the structure set"
    grep -q "^wrote *c.nii" .stdout && ! grep -q "^wrote.*dcm" .stdout || fail "what was written is not said"
    mv c.csv first.csv; mv c.nii first.nii
    expect 3 slice open.stl --spacing 1,1,1 --frame ras --without-ct -o c.dcm -o c.nii -o c.csv
    cmp c.csv first.csv && cmp c.nii first.nii || fail "the order of outputs matters"
    [[ ! -e c.dcm ]] || fail "a structure set of nothing"
}

# A box of 10 x 20 x 30 without one face, beside a whole one on top of it: what is open is said once, and measures nothing.
test_open_mesh() {
    cube whole.stl 0 6
    cube side.stl 0 5
    awk '/^vertex/ {$3 *= 2; $4 *= 3} 1' side.stl > f7_open.stl
    { awk '/^vertex/ {$4 = $4 * 3 + 30} 1' whole.stl; cat f7_open.stl; } > half.stl
    local words='30 of 30 layers (100 % of the height) have open contours: their area is not known; --stitch 10 would close them'
    expect 0 slice f7_open.stl --stitch 0 --spacing 1,1,1 --frame lps -o m.nii -o m.csv -o m.jsonl -o m.svg --report m.json
    [[ $(grep -c 'open contours' .stderr) == 1 ]] || fail "not said once"
    grep -qxF "lamella: warning: f7_open.stl: $words" .stderr || fail "not said as it should be"
    grep -qxF "open      $words" .stdout || fail "not in the summary"
    grep -qF "$words" m.meshes.csv || fail "not in the table"
    [[ $(grep -c '^f7_open,[0-9]*,[^,]*,[^,]*,[^,]*,[^,]*,,,1,0,1,0,,,' m.csv) == 30 ]] || fail "areas that are not known"
    [[ $(grep -c '"area_mm2":null,"perimeter_mm":null,.*"centroid_x_lps_mm":null' m.jsonl) == 30 ]] || fail "areas in JSON lines"
    expect_json m.json 30 open layers
    [[ $(json_value m.json open closed_by_mm) == 10.0000* ]] || fail "another length"
    expect 0 slice f7_open.stl --stitch 10 --layer-height 1 -o c.csv
    [[ $(grep -c '^f7_open,.*,200,60,1,0,0,0,5,10,' c.csv) == 30 && ! -s .stderr ]] || fail "the length that is named closes nothing"
    expect 0 slice f7_open.stl whole.stl --stitch 0 --spacing 1,1,1 --frame lps -o two.csv
    grep -q '^whole,12,1000,600,certified,$' two.meshes.csv || fail "the closed mesh has a warning of the open one"
    expect 0 slice half.stl --stitch 0 --layer-height 2 -o m.csv
    words='half.stl: 15 of 30 layers (50 % of the height) have open contours: their area is not known; --stitch 10 would close them'
    grep -qxF "lamella: warning: $words" .stderr || fail "not the half that is open"
    "$lamella" convert half.stl -o half.ply > /dev/null 2>&1 || fail "no PLY"
    expect 0 slice half.ply --stitch 0 --layer-height 2 --memory 5M -o half.csv
    grep -qF "${words/stl/ply}" .stderr || fail "not said with --memory"
    cmp half.csv m.csv || fail "--memory differs"
    expect 0 batch half.stl --stitch 0 --layer-height 2 -o 'b/{stem}.csv'
    grep -qF "\"warnings\":[\"half.stl: 15 of 30 layers (50 % of" b/results.jsonl || fail "not in results.jsonl"
}

# A mesh that reaches out of the image's slices is warned of.
test_beside_the_image() {
    sphere a.stl 2000
    expect 0 slice a.stl --spacing 2,2,2 --frame ras -o image.nii
    expect 0 make sphere --triangles 2000 --height 40 -o tall.stl
    expect_line stderr "warning: m.nii: tall reaches 20.000 mm beyond the image's slices" slice tall.stl --like image.nii --frame ras -o m.nii
    expect_line stderr "warning: m.dcm: tall reaches 20.000 mm" slice tall.stl --like image.nii --frame ras --without-ct -o m.dcm
}

test_tables() {
    sphere a.stl 2000
    expect 0 slice a.stl --layer-height 5 -o a.csv -o a.jsonl
    expect_files a.csv a.csv.lamella.json a.jsonl a.jsonl.lamella.json a.meshes.csv a.stl
    [[ $(wc -l < a.csv) == 5 && $(wc -l < a.jsonl) == 5 ]] || fail "not a line a layer"
    grep -q "^a,0,2.5," a.csv || fail "no first layer"
    grep -q ",certified,$" a.meshes.csv || fail "not certified"
    head -1 a.jsonl > first.json
    expect_json first.json mesh kind
    expect_json first.json certified certificate
}

# Coordinates are the patient's, and say so; what is stated twice or in upper case counts once.
test_frames() {
    cube box.stl 20 6
    expect_silent slice box.stl --spacing 2,2,4 --frame RAS -o t.csv -o t.jsonl -o t.h5 -o t.nii
    grep -q '"ras"' t.csv.lamella.json || fail "the record holds what was typed"
    [[ $(head -1 t.csv) == mesh,layer,height_lps_mm,cut_lps_mm,bottom_lps_mm,top_lps_mm,area_mm2,perimeter_mm,contours,holes,open,flat,centroid_x_lps_mm,centroid_y_lps_mm,centroid_z_lps_mm,min_x_lps_mm,* ]] ||
        fail "no columns that name the frame"
    [[ $(sed -n 3p t.csv) == box,1,5,4.99999*,3,7,100,40,1,0,0,0,-25,-5,4.99999*,-30,-10,4.99999*,-20,0,4.99999* ]] || fail "not where the box is"
    grep -q '"height_lps_mm":5,.*"centroid_x_lps_mm":-25,"centroid_y_lps_mm":-5,' t.jsonl || fail "not where the box is, in JSON"
    expect 0 convert t.h5 -o c.csv
    cmp c.csv t.csv || fail "convert gives other places"
    expect 0 slice box.stl --like t.nii --frame ras -o c.csv
    cmp c.csv t.csv || fail "--like gives other places"
    mkdir big && expect 0 convert box.stl -o big/box.stl
    expect 0 slice big/box.stl --like t.nii --frame ras --memory 20M -o c.csv
    cmp c.csv t.csv || fail "--memory gives other places"
    (printf '3D Slicer output. SPACE=LPS'; head -c 53 /dev/zero; tail -c +81 big/box.stl) > lps.stl
    expect 0 slice lps.stl --spacing 2,2,4 --frame lps -o c.csv
    grep -q "states the patient frame" .stderr && fail "a frame that is stated twice alike is doubted"
    expect_line stderr "lps.stl: states the patient frame LPS, which holds instead of --frame RAS" slice lps.stl --spacing 2,2,4 --frame ras -o c.csv
    expect 0 slice box.stl --fill-rule NON-ZERO --fill-from 3:EVEN-ODD --datum ZERO --side ABOVE --unit MM --grid FINEST --progress NEVER -o UPPER.CSV
    expect 0 slice box.stl --spacing 20,20,20 --frame ras --coverage --subslices 8 -o thin.nii
    grep -q thinner .stderr && fail "a warning in spite of the remedy"
    expect 0 slice box.stl --spacing 20,20,20 --frame ras -o thin.nii
    grep -q "thin.nii: box is thinner than a voxel: its box is 10.0000 x 10.0000 x 10.0000 mm, its walls 10.0000 mm on average; --coverage --subslices 8 writes" .stderr ||
        fail "no warning of a mesh thinner than a voxel"
}

test_pictures() {
    sphere a.stl 2000
    sphere b.stl 500
    "$lamella" slice a.stl --layer-height 1 -o a.png > .stdout 2> .stderr || { grep -q "without PNG" .stderr && skip "no libpng"; }
    expect 0 slice a.stl b.stl --layer-height 1 -o a.png --threads 1
    expect_files a.png a.png.lamella.json a.stl b.stl
    cp a.png one.png
    expect 0 slice a.stl b.stl --layer-height 1 -o a --to png --threads 3
    cmp a.png one.png || fail "bytes depend on threads"
    expect 0 slice a.stl --layer-height 1 -o a.png --picture-layer 19
    cmp -s a.png one.png && fail "--picture-layer shows the sheet"
}

test_archives() {
    sphere a.stl 2000
    sphere b.stl 500
    expect 0 slice a.stl --spacing 1,1.5,2 --frame ras -o a.h5 -o a.nii.gz -o a.csv --threads 1
    expect_json a.h5.lamella.json "$(sha256sum a.h5 | cut -d' ' -f1)" output sha256
    expect 0 slice a.stl --spacing 1,1.5,2 --frame ras -o again.h5 --threads 3
    cmp again.h5 a.h5 || fail "bytes depend on threads"
    expect 0 slice a.stl --layer-height 1 -o a.svg -o plain.h5
    # An archive becomes the bytes that slice writes.
    expect 0 convert a.h5 -o c.nii.gz -o c.csv
    cmp c.nii.gz a.nii.gz && cmp c.csv a.csv || fail "convert writes other bytes"
    expect_json c.nii.gz.lamella.json "$(sha256sum a.h5 | cut -d' ' -f1)" inputs 0 sha256
    expect 0 verify --inputs a.h5
    expect 0 convert plain.h5 -o c.svg
    cmp c.svg a.svg || fail "convert writes another SVG"
    expect 0 convert plain.h5 -o - --progress never
    cmp .stdout a.svg || fail "convert writes another SVG on standard output"
    expect 0 convert a.h5 --like a.nii.gz -o c.h5
    cmp c.h5 a.h5 || fail "an archive of an archive differs"
    expect 0 merge plain.h5 -o m.h5
    cmp m.h5 plain.h5 || fail "the whole merged is not the whole"
    expect_json m.h5.lamella.json "$(sha256sum plain.h5 | cut -d' ' -f1)" inputs 0 sha256
    rm -f ./c.* ./m.*
    expect 0 slice b.stl --like a.nii.gz --frame ras -o b.h5
    expect 0 convert a.h5 b.h5 -o two.nii
    expect 0 slice a.stl b.stl --like a.nii.gz --frame ras -o both.nii
    cmp two.nii both.nii || fail "two archives make another mask than two meshes"
    expect 0 slice b.stl --spacing 2,2,2 --subslices 3 --frame ras -o share.h5 -o share.nii
    expect 0 convert share.h5 -o c.nii
    cmp c.nii share.nii || fail "convert writes other shares"
    # Ranges of layers join to the whole, for an image as for uniform layers.
    for range in 0:4 4:9 9:; do
        expect 0 slice a.stl --layer-height 1 --layers "$range" -o "plain${range%%:*}.h5"
        expect 0 slice a.stl --spacing 1,1.5,2 --frame ras --layers "$range" -o "image${range%%:*}.h5"
    done
    expect 0 merge plain9.h5 plain0.h5 plain4.h5 -o m.h5
    cmp m.h5 plain.h5 || fail "the joined parts are not the whole"
    expect 0 merge image9.h5 image0.h5 image4.h5 -o m.h5
    cmp m.h5 a.h5 || fail "the joined parts are not the whole, of an image"
    expect 0 slice a.stl --layer-height 1 --layers 4:9 --memory 20M -o m.h5
    cmp m.h5 plain4.h5 || fail "a budget of memory changes an archive"
    expect 0 convert plain4.h5 -o n.csv -o n.svg -o n.png
}

test_split_objects() {
    local long faces='f 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n'
    long=$(printf 'n%.0s' {1..70})
    printf "v 0 0 0\nv 9 0 0\nv 0 9 0\nv 0 0 9\ng rib\n${faces}g $long\n${faces}g rib\nv 0 0 1\n${faces//4/5}" > a.obj
    expect_line stderr "the name 'rib' repeats: mesh 3 is called 'rib (2)'" slice a.obj --split objects --spacing 1,1,1 --frame lps --without-ct -o m.nii -o m.dcm
    grep -q "the name '$long' is written as '${long:6}'" .stderr || fail "a name that is cut is not told"
    cut -d, -f1,2 m.labels.csv | diff - <(printf 'label,name\n1,rib\n2,%s\n3,rib (2)\n' "$long") || fail "other labels"
    grep -q "${long:6}" m.dcm && grep -q 'rib (2)' m.dcm || fail "other ROIs"
    expect 0 slice a.obj --split objects --layer-height 1 -o rows.csv
    (($(grep -c '^rib (2),' rows.csv) == 9)) || fail "a low object is not cut at the planes of the whole"
    expect 0 verify m.nii m.dcm rows.csv
    expect_failure 2 "takes one mesh, not several" slice a.obj --split objects -o m.svg
    expect_line stdout "^  solid, 4 triangles: rib$" info a.obj
}
