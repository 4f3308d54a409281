# Many meshes by one command. Sourced by cli.sh.

# meshes: in/ with three spheres, a torus in a folder, and a file that is no mesh.
meshes() {
    local i
    mkdir -p in/sub
    for i in 1 2 3; do sphere in/s$i.stl ${i}000; done
    expect 0 make torus --triangles 2000 -o in/sub/t.stl
    echo "no mesh" > in/bad.stl
}

# result FILE MESH KEY...: a value of the line of MESH.
result() {
    local file=$1 mesh=$2
    shift 2
    grep -F "{\"mesh\":\"$mesh\"" "$file" > .line || fail "$file: no line of $mesh"
    json_value .line "$@"
    rm .line
}

expect_result() {
    local want=$1 got
    shift
    got=$(result out/results.jsonl "$@") || exit 1
    [[ "$got" == "$want" ]] || fail "$*: '$got', not '$want'"
}

# expect_counts STATUS TEXT ARGUMENT...: requires the status, and this in the line that counts.
expect_counts() {
    local status=$1 text=$2
    shift 2
    expect "$status" "$@"
    grep -qF "meshes    $text" .stdout || fail "lamella $*: not '$text'"
}

test_batch() {
    meshes
    expect_counts 5 "5: 4 done, 0 unchanged, 1 failed" batch in -o 'out/{dir}/{stem}.csv' --to csv,svg --layer-height 1
    grep -q "^failed    in/bad.stl: is no STL" .stdout || fail "the failed one is not named"
    grep -q "^retry " .stdout || fail "how to retry is not said"
    [[ $(tail -1 .stderr) == "lamella: 1 of 5 meshes failed" ]] || fail "the last line does not count"
    expect_result done in/sub/t.stl status
    expect_result failed in/bad.stl status
    expect_result 2000 in/s2.stl triangles
    expect_result 20 in/s2.stl layers
    expect_result out/sub/t.csv in/sub/t.stl outputs 0 path
    expect_result "$(stat -c %s out/sub/t.svg)" in/sub/t.stl outputs 3 bytes
    [[ ! -e out/bad.csv ]] || fail "a bad mesh has an output"
    # What one process writes is what slice writes.
    mkdir alone
    expect 0 slice in/s2.stl --layer-height 1 -o alone/s2.svg
    cmp alone/s2.svg out/s2.svg || fail "the batch writes other bytes"
    # The order is that of names; the number of processes is seen nowhere.
    cut -d'"' -f4 out/results.jsonl | sort -c || fail "results are not in order"
    mv out one
    expect 5 batch in -o 'out/{dir}/{stem}.csv' --to csv,svg --layer-height 1 --jobs 1 --threads 2
    diff -r one out || fail "the tree depends on --jobs"
    expect 5 batch in -o 'out/{dir}/{stem}.csv' --to csv,svg --layer-height 1 --force --progress always
    grep -q "of 5 meshes" .stderr || fail "no progress"
    expect 0 batch 'in/s?.stl' in/sub/t.stl -o 'glob/{parent}-{name}.svg' --layer-height 1
    [[ -s glob/in-s3.stl.svg && -s glob/sub-t.stl.svg && -s glob/results.jsonl ]] || fail "names of a glob"
    expect 0 batch in/s1.stl --layer-height 1 -o '{stem}.svg' --report 'reports/{stem}.json' --results log
    [[ -s s1.svg && -s reports/s1.json && -s log/results.jsonl ]] || fail "--report or --results"
}

test_batch_resume() {
    meshes
    rm in/bad.stl
    local -a command=(batch in -o 'out/{dir}/{stem}.csv' --layer-height 1)
    expect 0 "${command[@]}"
    cp -r out whole
    expect_counts 0 "4: 0 done, 4 unchanged, 0 failed" "${command[@]}"
    diff -r whole out || fail "nothing to do changes the tree"
    rm out/s2.csv
    : > out/s3.csv
    expect_counts 0 "4: 2 done, 2 unchanged, 0 failed" "${command[@]}"
    diff -r whole out || fail "lost outputs"
    # A line that is missing, and one that was torn.
    sed -i 1d out/results.jsonl
    truncate -s -9 out/results.jsonl
    expect_counts 0 "4: 2 done, 2 unchanged, 0 failed" "${command[@]}"
    diff -r whole out || fail "lost lines"
    # Files aside of processes that are no more; others' stay.
    touch out/.s1.csv.999999999-1.part out/.results.jsonl.999999999-12.part out/sub/.t.csv.lamella.json.999999999-3.part
    touch out/.s9.csv.999999999-1.part out/.s1.csv.part out/.s1.csv.1a-1.part
    expect 0 "${command[@]}"
    [[ $(find out -name '.*' -printf '%f ' | tr ' ' '\n' | sort | xargs) == ".s1.csv.1a-1.part .s1.csv.part .s9.csv.999999999-1.part" ]] ||
        fail "leftovers: $(find out -name '.*')"
    find out -name '.*' -delete
    expect_counts 0 "4: 4 done, 0 unchanged, 0 failed" "${command[@]}" --force
    diff -r whole out || fail "--force writes other bytes"
    # A later batch of other meshes keeps these lines.
    sphere other.stl
    expect_counts 0 "1: 1 done" batch other.stl -o 'out/{stem}.csv' --layer-height 1
    [[ $(wc -l < out/results.jsonl) == 5 ]] || fail "lines of the earlier batch are gone"
    expect_counts 0 "4: 0 done, 4 unchanged" "${command[@]}"
    # Lines of a version with other defaults, which it did not state.
    sed -i 's/,"--stitch=auto","--fill-rule=non-zero"//; s/,"stitch_mm":[0-9.]*//' out/results.jsonl
    grep -q 'stitch' out/results.jsonl && fail "the lines still state what older ones do not"
    expect_counts 0 "4: 4 done, 0 unchanged" "${command[@]}"
    grep -qx 'again     4 meshes that an older version of lamella sliced, whose defaults were others' .stdout || fail "no word of the older version"
}

test_batch_changes() {
    meshes
    rm in/bad.stl
    expect 0 batch in -o 'out/{dir}/{stem}.csv' --layer-height 1
    expect_counts 0 "4: 4 done" batch in -o 'out/{dir}/{stem}.csv' --layer-height 2
    touch in/s1.stl
    expect_counts 0 "4: 1 done, 3 unchanged" batch in -o 'out/{dir}/{stem}.csv' --layer-height 2
    expect_counts 0 "4: 4 done" batch in -o 'out/{dir}/{stem}.csv' --layer-height 2 --hash
    touch in/s1.stl
    expect_counts 0 "4: 0 done, 4 unchanged" batch in -o 'out/{dir}/{stem}.csv' --layer-height 2 --hash
    local time
    time=$(stat -c %y in/s1.stl)
    printf '\x01' | dd of=in/s1.stl bs=1 seek=90 conv=notrunc status=none
    touch -d "$time" in/s1.stl
    expect_counts 0 "4: 1 done, 3 unchanged" batch in -o 'out/{dir}/{stem}.csv' --layer-height 2 --hash
    expect_result "$(sha256sum in/s1.stl | cut -d' ' -f1)" in/s1.stl inputs 0 sha256
    # A file that an option names is an input, too.
    printf '1 0 0 0 0 1 0 0 0 0 1 0\n' > same.txt
    expect 0 batch in/s1.stl -o 'out/{stem}.csv' --transform same.txt
    expect_counts 0 "1: 0 done, 1 unchanged" batch in/s1.stl -o 'out/{stem}.csv' --transform same.txt
    printf '1 0 0 0 0 1 0 0 0 0 1 5\n' > same.txt
    expect_counts 0 "1: 1 done" batch in/s1.stl -o 'out/{stem}.csv' --transform same.txt
    # A mesh that was good and is not any more is told; what it was stays.
    echo bad > in/s2.stl
    expect 5 batch in/s2.stl -o 'out/{stem}.csv' --layer-height 2
    [[ -s out/s2.csv ]] || fail "the earlier output is gone"
    expect_result failed in/s2.stl status
}

test_batch_manifest() {
    meshes
    printf '\xef\xbb\xbfpath,layer-height,fill_rule,drop-collinear\r\n"in/s1.stl",5,,\r\nin/s2.stl,,"non-zero",yes\r\n\r\nin/sub/t.stl,,,no\r\n' > list.csv
    expect 0 batch list.csv -o 'out/{stem}.csv' --layer-height 2
    expect_result --layer-height=5 in/s1.stl options 0
    expect_result --layer-height=2 in/s2.stl options 0
    expect_result --stitch=auto in/s2.stl options 1
    expect_result --fill-rule=non-zero in/s2.stl options 2
    expect_result --drop-collinear in/s2.stl options 3
    expect_result 4 in/s1.stl layers
    cat > list.jsonl << 'END'
{"path": "in/s1.stl", "spacing": [4, 4, 5.5], "frame": "ras", "output": ["m/{stem}.nii.gz", "m/{stem}.csv"]}

{"path": "in/s1.stl", "planes": "1,2,3", "output": "m/cut.svg", "threads": 1, "like": null, "coverage": false}
END
    expect 0 batch list.jsonl --results out
    [[ -s m/s1.nii.gz && -s m/s1.csv && -s m/cut.svg ]] || fail "outputs of a manifest"
    grep -q -- '"options":\["--spacing=4,4,5.5","--frame=ras","--stitch=auto","--fill-rule=non-zero"\]' out/results.jsonl || fail "options of a manifest"
}

# Manifests as spreadsheets write them.
test_batch_spreadsheets() {
    meshes
    local separator
    for separator in ';' '\t'; do
        printf '\xef\xbb\xbfpath;layer-height;planes;\r\nin/s1.stl;2,5;;\r\n;;;\r\nin/s2.stl;;1,2,4;\r\n' > list.csv
        [[ $separator == ';' ]] || sed -i 'y/;/\t/' list.csv
        expect 0 batch list.csv -o 'out/{stem}.csv' --force
        expect_result --layer-height=2.5 in/s1.stl options 0
        expect_result --planes=1,2,4 in/s2.stl options 0
    done
    printf 'path,layer-height,\nin/s1.stl,"2,5",,\n' > list.csv
    expect 0 batch list.csv -o 'out/{stem}.csv'
    expect_result --layer-height=2.5 in/s1.stl options 0
}

# Names that are no UTF-8, and one that looks like such a name as text: bytes are the identity, and text is UTF-8.
test_batch_names() {
    mkdir in
    sphere in/a$'\xe4'.stl
    sphere in/a$'\xe5'.stl 2000
    sphere 'in/a\xe4.stl' 3000
    local -a command=(batch in -o 'out/{stem}.csv' --layer-height 1)
    expect_counts 0 "3: 3 done" "${command[@]}"
    expect_result 3000 'in/a\\x5cxe4.stl' triangles
    expect_result 2000 'in/a\\xe5.stl' triangles
    [[ -s out/a$'\xe4'.csv && -s out/a$'\xe5'.csv && -s 'out/a\xe4.csv' ]] || fail "outputs are one"
    mv out whole
    expect 0 "${command[@]}" --shard 0/2
    expect 0 "${command[@]}" --shard 1/2
    expect 0 batch --merge out
    cmp whole/results.jsonl out/results.jsonl || fail "merged results differ"
    expect_counts 0 "3: 0 done, 3 unchanged" "${command[@]}"
    printf '%s\n' '{"path":"in/a\\xe5.stl"}' > list.jsonl
    expect_counts 0 "1: 0 done, 1 unchanged" batch list.jsonl -o 'out/{stem}.csv' --layer-height 1
    expect 0 verify out/a*[!s].csv --inputs
    echo bad > in/a$'\xe4'.stl
    expect 5 "${command[@]}"
    expect_result "is no STL, OBJ, OFF, PLY, VTK, VTP or 3MF file: text that begins with 'bad'" 'in/a\\xe4.stl' reason
    cat .stdout .stderr > words
    expect 0 slice in/a$'\xe5'.stl --layer-height 1 -o b$'\xff'.svg --report report.json
    cat .stdout .stderr >> words
    expect_failure 3 'in/b\xff.stl' slice in/b$'\xff'.stl
    cat .stderr words report.json whole/*.csv whole/*.json out/results.jsonl b$'\xff'.svg > all
    iconv -f UTF-8 -t UTF-8 all > /dev/null || fail "text is no UTF-8"
}

test_batch_bad_input() {
    meshes
    if ((EUID != 0)); then
        mkdir locked
        chmod 0 locked
        expect_failure 3 "locked: cannot be listed: Permission denied" batch locked -o 'o/{stem}.csv'
        rmdir locked
    fi
    mkdir foreign
    printf 'one\ntwo\n' > foreign/results.jsonl
    expect_failure 3 "foreign/results.jsonl:1: no line of lamella batch" batch in/s1.stl -o 'foreign/{stem}.csv'
    [[ $(cat foreign/results.jsonl) == $'one\ntwo' ]] || fail "a foreign file was changed"
    # What only some meshes fail of is theirs alone: one that is not there, masks of 10^12 voxels, a mesh without frame.
    expect_counts 5 "2: 1 done, 0 unchanged, 1 failed" batch in/none.stl in/s1.stl -o 'out/{stem}.csv'
    grep -q "^failed    in/none.stl: .*No such file" .stdout || fail "no reason"
    expect 5 batch in/s1.stl -o 'out/{stem}.nrrd' --spacing 0.0001,0.0001,1 --frame lps
    grep -q "^failed    in/s1.stl: .*larger than 2^38 bytes" .stdout || fail "no reason"
    expect 5 batch in/s1.stl -o 'out/{stem}.nrrd' --spacing 1,1,1
    grep -q "^failed    in/s1.stl: states no patient frame" .stdout || fail "no reason"
    [[ ! -e out/s1.nrrd ]] || fail "a failed mask was written"
}

test_batch_shards() {
    meshes
    local -a command=(batch in -o 'out/{dir}/{stem}.csv' --layer-height 1)
    expect 5 "${command[@]}"
    mv out whole
    local i
    for i in 0 1 2; do
        "$lamella" "${command[@]}" --shard $i/3 > .stdout 2> .stderr
        [[ -e out/results.$i-of-3.jsonl ]] || fail "shard $i has no results"
    done
    mv out/results.1-of-3.jsonl aside
    expect_failure 3 "'out/results.1-of-3.jsonl' is missing: shard 1/3 has not ended" batch --merge out
    mv aside out/results.1-of-3.jsonl
    expect_counts 5 "5: 4 done, 1 failed" batch --merge out
    expect 5 batch --merge out/results.2-of-3.jsonl out/results.0-of-3.jsonl out/results.1-of-3.jsonl
    expect_failure 2 "is given twice" batch --merge out out/results.0-of-3.jsonl
    cp out/results.0-of-3.jsonl out/results.0-of-2.jsonl
    expect_failure 3 "are of different batches" batch --merge out
    rm out/results.0-of-2.jsonl
    # Other shards know what is done.
    expect_counts 0 "2: 0 done, 2 unchanged" "${command[@]}" --shard 1/2
    rm out/results.*-of-*
    diff -r whole out || fail "shards make another tree"
}

# A mesh larger than all of the memory is cut in ranges, alone.
test_batch_memory() {
    meshes
    rm in/bad.stl
    sphere in/large.stl 1000000
    local -a command=(batch in -o 'out/{stem}.svg' --to svg,csv --layer-height 0.5 --memory 64M)
    expect_counts 0 "5: 5 done" "${command[@]}"
    expect_result 1000000 in/large.stl triangles
    expect 0 slice in/large.stl --layer-height 0.5 -o large.svg
    cmp large.svg out/large.svg || fail "a mesh larger than the memory has other bytes"
    expect_counts 0 "5: 0 done, 5 unchanged" "${command[@]}"
    expect 0 batch in -o 'masks/{stem}.nrrd' --spacing 2,2,2 --frame lps --memory 64M
    expect 0 slice in/large.stl --spacing 2,2,2 --frame lps -o large.nrrd
    cmp large.nrrd masks/large.nrrd || fail "a mesh larger than the memory has another mask"
    expect_counts 5 "5: 4 done, 0 unchanged, 1 failed" batch in -o 'welded/{stem}.svg' --weld 0.001 --memory 64M
    grep -q "^failed    in/large.stl: needs about .* MB of memory, more than --memory has for all: --weld excludes --memory" .stdout ||
        fail "no reason"
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
    expect_counts 5 "5: 4 done, 0 unchanged, 1 failed" batch in slow.jsonl -o 'out/{stem}.csv' --timeout 2 --retries 0
    expect_result "took longer than 2 s" slow.stl reason
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
    expect_result "ended by signal 9 (Killed)" slow.stl reason
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
