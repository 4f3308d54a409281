# Outputs against their records. Sourced by cli.sh.

# verdict STATUS TEXT ARGUMENT...: verify ends so, and a line of it contains the text.
verdict() {
    local status=$1 text=$2
    shift 2
    expect "$status" verify "$@"
    grep -qF -- "$text" .stdout || fail "lamella verify $*: no line with '$text'"
    [[ $status == 0 || $(wc -l < .stderr) == 1 ]] || fail "lamella verify $*: not one line of failure"
}

# replaced FILE FROM TO: in a copy that takes the file's place.
replaced() {
    sed "s|$2|$3|" "$1" > .changed && ! cmp -s .changed "$1" || fail "nothing to replace in $1"
    mv .changed "$1"
}

organs() {
    mkdir -p in out temporary
    export TMPDIR=$PWD/temporary  # other tests verify at the same time
    sphere in/a.stl 2000
    sphere in/b.stl 500
    expect 0 slice in/a.stl in/b.stl --spacing 1,1.5,2 --frame ras -o out/m.nii.gz -o out/m.seg.nrrd -o out/m.csv -o out/m.jsonl
}

test_verify() {
    organs
    local file
    for file in m.nii.gz m.seg.nrrd m.csv m.jsonl; do
        verdict 0 "out/$file: as recorded" out/$file
        verdict 0 "out/$file: as recorded, and so are its inputs; equal when made again" --inputs out/$file
    done
    # Records of earlier versions name options otherwise.
    replaced out/m.csv.lamella.json '"--stitch"' '"--close-gaps"'
    verdict 0 "equal when made again" --inputs out/m.csv
    verdict 0 "as recorded" out/m.csv.lamella.json
    verdict 0 "out/m.csv: as recorded" out
    [[ $(wc -l < .stdout) == 4 ]] || fail "not a line for each record"
    verdict 0 "equal when made again" --mesh in/a.stl --mesh in/b.stl out --threads 1
    # From another folder, with the meshes elsewhere and under other names.
    mkdir moved
    cp in/a.stl moved/x.stl
    mv in/b.stl moved/y
    mv in/a.stl moved/z
    (cd moved && expect 0 verify ../out && expect 0 verify --mesh x.stl --mesh y ../out) || exit 1
    verdict 3 "out/m.csv: not verified: cannot read" --inputs out/m.csv
    verdict 3 "made of 2 meshes, and --mesh gives 1" --mesh moved/y out/m.csv
    # Meshes in another order are other inputs.
    verdict 5 "moved/z': has 100,084 bytes, its record says 25,084" --mesh moved/y --mesh moved/z out/m.csv
}

test_verify_changes() {
    organs
    cp -r out kept
    cp -r in meshes
    local file
    # One byte of the output.
    for file in m.nii.gz m.seg.nrrd m.csv m.jsonl; do
        printf 'X' | dd of=out/$file bs=1 seek=100 conv=notrunc 2> /dev/null
        verdict 5 "out/$file: differs: its SHA-256 is not that of its record" out/$file
        verdict 5 "made again it has other bytes" --inputs out/$file
        printf 'X' >> out/$file
        verdict 5 "bytes, its record says" out/$file
        cp kept/$file out/
    done
    expect 0 verify --inputs out
    # What lies beside an output.
    printf 'X' >> out/m.labels.csv
    verdict 0 "as recorded" out/m.nii.gz
    verdict 5 "'m.labels.csv' beside it differs" --inputs out/m.nii.gz
    rm out/m.labels.csv
    verdict 5 "'m.labels.csv' beside it is missing" --inputs out/m.nii.gz
    cp kept/m.labels.csv out/
    # One byte of a mesh: a coordinate of a facet.
    printf '\x3f' | dd of=in/b.stl bs=1 seek=$((84 + 50 * 9 + 15)) conv=notrunc 2> /dev/null
    verdict 0 "as recorded" out/m.csv
    verdict 5 "in/b.stl': its SHA-256 is not that of its record" --inputs out/m.csv
    cp meshes/b.stl in/
    # The record.
    local record=out/m.csv.lamella.json
    for change in 's|"result_hashes": \[|&"0123456789abcdef",|;the hash' 's|"patient_frame": "RAS"|"patient_frame": "LPS"|;the patient frame' \
                  's|"fill_rule": "non-zero"|"fill_rule": "positive"|;the fill rule' 's|1,1.5,2|1,1.5,3|;made again it has other bytes' \
                  's|"ras"|"lps"|;made again it has other bytes'; do
        sed "${change%;*}" kept/m.csv.lamella.json > $record
        cmp -s $record kept/m.csv.lamella.json && fail "nothing changed by $change"
        expect_not_right --inputs out/m.csv
    done
    cp kept/m.csv.lamella.json $record
    # Two at once: the worse counts.
    printf 'X' >> out/m.nii.gz
    rm out/m.jsonl
    verdict 5 "out/m.jsonl: not verified: cannot read" out
    grep -q "1 of 4 outputs differs, 1 of 4 outputs not verified" .stderr || fail "no summary"
    [[ $(ls temporary | wc -l) == 0 ]] || fail "temporary folders are left behind"
}

# expect_dicom ARGUMENT...: false where this build has no DICOM.
expect_dicom() {
    "$lamella" "$@" > .stdout 2> .stderr || { grep -q "without DICOM" .stderr && return 1; fail "lamella $*"; }
}

# Status 5, or 3 where it can no longer be made.
expect_not_right() {
    local got=0
    "$lamella" verify "$@" > .stdout 2> .stderr || got=$?
    [[ $got == 5 || $got == 3 ]] || fail "lamella verify $*: exit status $got"
}

# What convert and merge make is made again from the archives.
test_verify_archives() {
    organs
    "$lamella" slice in/a.stl --spacing 1,1.5,2 --frame ras -o a.h5 > .stdout 2> .stderr ||
        { grep -q "no HDF5" .stderr && skip "no HDF5"; fail "no archive"; }
    expect 0 slice in/b.stl --like out/m.nii.gz --frame ras -o b.h5
    expect 0 convert a.h5 b.h5 --like out/m.nii.gz -o two.nii.gz -o two.csv
    expect_json two.csv.lamella.json convert command
    local range
    for range in 0:4 4:9 9:; do
        expect 0 slice in/a.stl --spacing 1,1.5,2 --frame ras --layers "$range" -o "part${range%%:*}.h5"
    done
    expect 0 merge part9.h5 part0.h5 part4.h5 -o whole.h5
    expect_json whole.h5.lamella.json merge command
    expect 0 convert whole.h5 -o w.h5 -o w.png -o w.nrrd --coverage --picture-layer 3
    verdict 0 "equal when made again" --inputs two.nii.gz two.csv whole.h5 w.h5 w.png w.nrrd
    [[ $(grep -c "equal when made again" .stdout) == 6 ]] || fail "not all are made again"
    # Archives elsewhere, in the order of the record.
    mkdir moved
    mv part?.h5 moved/
    verdict 3 "cannot read" --inputs whole.h5
    verdict 0 "equal when made again" --mesh moved/part9.h5 --mesh moved/part0.h5 --mesh moved/part4.h5 whole.h5
    verdict 3 "made of 3 archives, and --mesh gives 1" --mesh moved/part9.h5 whole.h5
    mv moved/part?.h5 .
    # Another byte of the output, of an archive, of a table beside it; a hash that is not that of the layers.
    printf 'X' | dd of=two.csv bs=1 seek=100 conv=notrunc 2> /dev/null
    verdict 5 "made again it has other bytes" --inputs two.csv
    printf 'X' >> two.labels.csv
    verdict 5 "'two.labels.csv' beside it differs" --inputs two.nii.gz
    cp part4.h5 kept.h5
    printf 'X' >> part4.h5
    verdict 5 "part4.h5': has" --inputs whole.h5
    cp kept.h5 part4.h5
    cp whole.h5.lamella.json kept.json
    sed -i 's|"result_hashes": \[|&"0123456789abcdef",|' whole.h5.lamella.json
    verdict 5 "the hash of mesh 1" --inputs whole.h5
    replaced whole.h5.lamella.json '"merge"' '"convert"'
    expect_not_right --inputs whole.h5
    cp kept.json whole.h5.lamella.json
    replaced whole.h5.lamella.json '"merge"' '"batch"'
    verdict 3 "its record names the command 'batch'" --inputs whole.h5
    replaced whole.h5.lamella.json '"options": \[\]' '"options": ["--frame","ras"]'
    replaced whole.h5.lamella.json '"batch"' '"merge"'
    verdict 3 "--frame" --inputs whole.h5
    [[ $(ls temporary | wc -l) == 0 ]] || fail "temporary folders are left behind"
}

test_verify_nonsense() {
    organs
    local record=out/m.csv.lamella.json
    cp $record kept.json
    nonsense() {
        verdict 3 "$1" --inputs out/m.csv
        cp kept.json $record
    }
    : > $record; nonsense "no record of lamella"
    printf '{' > $record; nonsense "not JSON at byte"
    printf '[1,2]' > $record; nonsense "a member is missing or of another type"
    head -c 100000 /dev/zero > $record; nonsense "not JSON"
    replaced $record '"bytes": [0-9]*' '"bytes": "many"'; nonsense "a member is missing or of another type"
    replaced $record '"path": "m.csv"' '"path": "../m.csv"'; nonsense "its record names the output '../m.csv'"
    replaced $record '"path": "m.csv"' '"path": ""'; nonsense "its record names the output ''"
    # Options that write, or that slice does not have.
    replaced $record '"--frame"' '"--report"'; nonsense "'--report' is no option that a record holds"
    replaced $record '"--frame"' '"--output"'; nonsense "'--output' is no option that a record holds"
    replaced $record '"--frame"' '"in/a.stl"'; nonsense "'in/a.stl' is no option that a record holds"
    replaced $record '"--frame"' '"--worker"'; nonsense "is no option that a record holds"
    replaced $record '"--frame"' '"--help"'; nonsense "is no option that a record holds"
    replaced $record '^    "non-zero"' '"non-zero","--like"'; nonsense "has no value"
    replaced $record '"ras"' '"no frame"'; nonsense "is not one of lps|ras"
    replaced $record '"result_hashes": \[' '"result_hashes": ["0","0",'; nonsense "its record has 2 inputs and 4 hashes"
    # Inputs that lead elsewhere.
    replaced $record '"path": "in/a.stl"' '"path": "in/b.stl"'; verdict 5 "differs" --inputs out/m.csv; cp kept.json $record
    replaced $record '"path": "in/a.stl"' '"path": "-"'; nonsense "came from standard input"
    rm $record
    verdict 3 "cannot read" out/m.csv
    verdict 3 "cannot read" none.csv
    verdict 3 "no records in the folder" in
}

test_verify_options() {
    sphere a.stl 2000
    printf '1\n2.5\n# three\n3\n' > heights.txt
    printf '1 0 0 5\n0 0 1 0\n0 -1 0 0\n' > matrix.txt
    expect 0 slice a.stl --planes heights.txt --transform matrix.txt --fill-rule non-zero --drop-collinear --offset -0.5 -o t.csv -o t.png
    expect_json t.csv.lamella.json "$(sha256sum heights.txt | cut -d' ' -f1)" inputs 1 sha256
    verdict 0 "equal when made again" --inputs t.csv t.png
    printf '4\n' >> heights.txt
    verdict 5 "heights.txt': has" --inputs t.csv
    expect 0 slice a.stl --planes=1,2.5 --side above --normal=0,-1,0 -o t.jsonl
    verdict 0 "equal when made again" --inputs t.jsonl
    # Options for another of the outputs.
    expect 0 slice a.stl --spacing 1,1,1 --frame lps --coverage --picture-layer 3 --subslices 2 -o s.nii -o s.csv -o s.png
    verdict 0 "s.csv: as recorded, and so" --inputs s.nii s.csv s.png
    if expect_dicom slice a.stl --spacing 1,1,1 --frame lps --without-ct --holes xor -o r.dcm -o r.csv; then
        verdict 0 "equal when made again" --inputs r.dcm r.csv
    fi
    expect 0 slice a.stl --layer-height 1 --memory 100M --layers 2:9 -o g.csv
    verdict 0 "equal when made again" --inputs g.csv
    expect 0 slice a.stl --like s.nii --frame lps -o l.nrrd
    verdict 0 "equal when made again" --inputs l.nrrd
    # A record of a version with another fill rule by default, which it did not state.
    cube left.stl 0 6
    cube right.stl 5 6
    cat left.stl right.stl > both.stl
    expect 0 slice both.stl --planes 2,5 --fill-rule contours -o old.csv
    sed -i -z 's/,\n *"--fill-rule",\n *"contours"//' old.csv.lamella.json
    grep -q '"--fill-rule"' old.csv.lamella.json && fail "the record states its rule"
    verdict 0 "equal when made again" --inputs old.csv
    # Standard input, and a mesh whose name is like an option.
    "$lamella" slice - --layer-height 1 -o i.jsonl < a.stl > .stdout 2> .stderr || fail "no slice of standard input"
    verdict 3 "give it with --mesh" --inputs i.jsonl
    verdict 0 "equal when made again" --mesh a.stl i.jsonl
    cp a.stl ./-a.stl
    expect 0 slice ./-a.stl --layer-height 1 -o d.jsonl
    verdict 0 "equal when made again" --inputs d.jsonl
    # An absolute path, and one that leads up.
    mkdir -p deep/er
    (cd deep/er && expect 0 slice ../../a.stl --layer-height 1 -o u.jsonl && expect 0 slice "$folder/a.stl" --layer-height 1 -o v.jsonl &&
        expect 0 verify --inputs u.jsonl v.jsonl) || exit 1
    SOURCE_DATE_EPOCH=12345 "$lamella" slice a.stl --layer-height 1 -o e.csv > .stdout || fail "no slice"
    expect_json e.csv.lamella.json 12345 source_date_epoch
    verdict 0 "equal when made again" --inputs e.csv
}
