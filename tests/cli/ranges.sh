# Meshes larger than memory, and some layers of a plan. Sourced by cli.sh.

# A file that is not taken is converted to PLY, with the command that the refusal names, and gives the same hash.
converted_ranges() {
    local want=$1 order
    for order in z random; do
        expect 0 convert "$order.stl" -o "$order.ply"
        TMPDIR=$PWD expect 0 slice "$order.ply" --hash --memory 6M
        [[ $(hash_of) == "$want" ]] || fail "$order.ply: another hash"
        grep -q "^ranges .* of layers within" .stdout || fail "no line on ranges"
    done
    expect 3 slice z.ply --memory 10k
    grep -q "^lamella: z.ply: a budget of 10240 bytes is too small: its .* stay in memory" .stderr || fail "does not name the vertices"
    head -c 4000000 z.ply > short.ply
    expect_failure 3 "byte 3999994: property 'vertex_indices' of 'face' 30755: " slice short.ply --memory 6M
    printf 'OFF\n4 4 0\n0 0 0\n1.1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n' > solid.off
    expect 0 slice solid.off --layer-height 0.1 --hash
    want=$(hash_of)
    expect 0 convert solid.off -o solid.ply
    expect 0 slice solid.ply --layer-height 0.1 --hash --memory 2M
    [[ $(hash_of) == "$want" ]] || fail "solid.ply: another hash"
    expect_line stderr "rounded to the 32 bits of STL" convert solid.off -o solid.stl
}

# What takes one layer after the other is written while the mesh is sliced, and has the bytes of the whole.
streamed_outputs() {
    expect 0 slice z.stl -o whole.svg -o whole.csv -o whole.jsonl
    expect 0 slice random.stl --memory 2M -o ranges.svg -o z.csv -o z.jsonl
    cmp -s whole.svg ranges.svg || fail "another SVG"
    expect 0 slice z.stl --memory 2M -o z.csv -o z.jsonl
    cmp -s whole.csv z.csv || fail "another CSV"
    tail -n +2 whole.jsonl | cmp -s - z.jsonl || fail "other JSON lines"
    expect 0 verify --inputs z.csv z.jsonl
    # Nothing is left where something fails, and what is there already stays.
    cp z.csv before.csv
    expect_failure 4 "cannot write 'none/a.svg'" slice z.stl --memory 2M -o z.csv -o none/a.svg
    cmp -s z.csv before.csv || fail "a failed run changed z.csv"
    head -c 4000084 z.stl > short.stl
    expect 3 slice short.stl --memory 2M -o short.svg
    [[ ! -e short.svg ]] || fail "half an SVG"
    # A file that fails midway takes those beside it along, which lack layers.
    ln -s /dev/full full.svg
    expect_failure 4 "cannot write 'full.svg'" slice z.stl --memory 2M --layer-height 0.05 -o beside.csv -o full.svg
    [[ ! -e beside.csv ]] || fail "half a table"
    # Without outputs nothing of the results is held, whatever the number of meshes. An instrumented program takes more.
    expect 0 slice z.stl random.stl --layer-height 0.01 --memory 20M
    if [[ -z ${ASAN_OPTIONS:-} ]]; then
        sed -n 's/^memory *\([0-9]*\).*/\1/p' .stdout | awk '$1 > 100 { large = 1 } END { exit large || NR != 2 }' || fail "holds results"
    fi
    # Of several formats, one of which takes the whole result, the bytes are the same.
    expect 0 slice z.stl --memory 2M -o mixed.svg -o mixed.png
    cmp -s whole.svg mixed.svg || fail "another SVG beside a picture"
}

# Voxels lie around the box that the file is read for once more.
voxel_ranges() {
    local -a voxels=(--spacing 20,17,15 --frame ras --unit in)
    expect 0 slice z.stl random.stl "${voxels[@]}" -o whole.nii
    expect 0 slice z.stl random.stl "${voxels[@]}" --memory 2M -o ranges.nii
    cmp -s whole.nii ranges.nii || fail "another mask"
}

test_ranges() {
    expect 0 make bone --triangles 100000 -o z.stl
    expect 0 make bone --triangles 100000 --order random -o random.stl
    local want budget mesh
    expect 0 slice z.stl --hash
    want=$(hash_of)
    [[ ${#want} == 16 ]] || fail "no hash"
    for mesh in z.stl random.stl; do
        for budget in 100M 2M 1500k 1600000; do
            TMPDIR=$PWD expect 0 slice "$mesh" --hash --memory "$budget"
            [[ $(hash_of) == "$want" ]] || fail "$mesh within $budget: another hash"
            grep -q "^ranges .* of layers within" .stdout || fail "no line on ranges"
        done
    done
    grep -q "temporary file" .stdout || fail "nothing was spilled"
    expect_files random.stl z.stl
    converted_ranges "$want"
    streamed_outputs
    voxel_ranges
    # Gaps are closed alike.
    cubes
    expect 0 convert cracked.stl -o cracked.ply
    expect 0 slice cracked.ply --planes 2,5,8 -o whole.svg
    expect 0 slice cracked.ply --planes 2,5,8 --memory 5M -o ranges.svg
    cmp whole.svg ranges.svg || fail "--memory closes other gaps"
}
