# Files that the tests begin with, each made by one function; sourced by cli.sh.

sphere() { expect 0 make sphere --triangles "${2:-1000}" --height 20 -o "$1"; }

le32() { printf '%b' "$(printf '\\x%02x\\x%02x\\x%02x\\x%02x' $(($1 & 255)) $(($1 >> 8 & 255)) $(($1 >> 16 & 255)) $(($1 >> 24 & 255)))"; }

# with_float FILE BITS: prints a binary file with the first coordinate of the first triangle replaced
with_float() { head -c 96 "$1"; le32 "$2"; tail -c +101 "$1"; }

# without_last FILE: prints a binary STL file of 1,000 triangles but for the last one, which leaves a hole with three edges.
without_last() { head -c 80 "$1"; le32 999; tail -c +85 "$1" | head -c $((999 * 50)); }

facet() { printf 'facet normal 0 0 1\nouter loop\n%sendloop\nendfacet\n' "$1"; }

# cube FILE X SIDES: writes an ASCII cube of 10 mm at x with the first SIDES of its six sides
cube() {
    local facet x=$2 y=$(($2 + 10))
    local -a at=("$x 0 0" "$y 0 0" "$y 10 0" "$x 10 0" "$x 0 10" "$y 0 10" "$y 10 10" "$x 10 10")
    local -a facets=(032 021 456 467 126 165 237 276 304 347 015 054)
    {
        echo solid
        for facet in "${facets[@]:0:2 * $3}"; do
            facet "$(printf 'vertex %s\n' "${at[${facet:0:1}]}" "${at[${facet:1:1}]}" "${at[${facet:2:1}]}")"$'\n'
        done
        echo endsolid
    } > "$1"
}

# turned FILE: prints a text STL file with each facet turned.
turned() { awk '/vertex/ { v[n++] = $0; if (n == 3) { print v[0]; print v[2]; print v[1]; n = 0 } next } { print }' "$1"; }

# tetrahedron FILE EDGE [X]: an OBJ file; its first corner lies at (X, 0, 0).
tetrahedron() {
    awk -v e="$2" -v x="${3:-0}" 'BEGIN {
        OFMT = CONVFMT = "%.17g"
        print "v", x, 0, 0; print "v", x + e, 0, 0; print "v", x, e, 0; print "v", x, 0, e
        print "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4" }' > "$1"
}

# A triangle that stands: it encloses nothing.
open_triangle() { { echo solid; facet $'vertex 0 0 0\nvertex 9 0 9\nvertex 0 9 9\n'; echo endsolid; } > "$1"; }

# Two of every kind of thing that goes wrong, or together: what transcripts speak of.
cubes() {
    cube left.stl 0 6
    cube right.stl 5 6
    cube open.stl 0 5
    cat left.stl right.stl > both.stl
    turned left.stl > inverted.stl
    turned right.stl | cat left.stl - > pair.stl
    sed -E 's/^vertex ([0-9]+) 0 /vertex \1 5 /; s/^vertex ([0-9]+) 10 /vertex \1 15 /' right.stl | cat left.stl - > through.stl
    awk '/^vertex 10 10 10$/ && ++n == 3 {$2 = 10.001} 1' left.stl > cracked.stl
    # Two opposite walls, 10 mm long and 8 mm apart, one of them flipped: ends face ends.
    awk '/outer loop/ {n++; k = 0} /^facet/ {m++} m == 7 || m == 8 {if (/vertex/) {
            if (++k == 1) {first = $0} else if (k == 2) {second = $0} else {print $0; print second; print first}
            next} print; next} m < 11 && m > 0 {next} 1' left.stl |
        awk '$1 == "vertex" && $3 == 10 {$3 = 8} 1' > mixed.stl
}

tetrahedra() {
    tetrahedron small.obj 0.0125
    tetrahedron plate.obj 50
    tetrahedron large.obj 25000
    tetrahedron here.obj 20
    tetrahedron away.obj 20 5000
    tetrahedron beyond.obj 2 5000
    tetrahedron edge.obj 0.9995
    tetrahedron wide.obj 1500
    tetrahedron speck.obj 1e-9
}

# Text that people write: heights, matrices.
texts() {
    printf '# heights\n-5, -2.5\n\n0 2.5 # more\r\n+5\n' > heights.txt
    printf '\xef\xbb\xbf-5;-2,5;0\r\n2,5;5;\r\n' > heights.csv  # as spreadsheets write them
    printf -- '-5\t-2,5\t0\n2,5\t5\n' > heights.tsv
    printf '2.5 -2.5\n5\n0 -5 2.5\n-5.0000000001\n' > order.txt
    printf '0,5\n1,5\n' > either.txt
    printf '0,5;1.5\n' > either.csv
    printf '\xff\xfe1\0\n\0' > wide.txt
    printf '1\n2\nthree\n' > bad.txt
    printf '1\n\0a\x1b%050d\n' 0 > binary.txt
    : > none.txt
    printf '7' > one.txt
    printf '1 0 0 0\n0 1 0 0\n0 0 2 0 # twice as tall\n' > tall.txt
    printf '1 0 0 0 0 1 0 0 0 0 2 0 0 0 0 1\n' > square.txt
    printf '\xef\xbb\xbf1 0 0 0\n0 1 0 0\n0 0 1 0\n' > same.txt
    printf '1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 2\n' > projective.txt
    printf '1 0 0 0\n0 1 0 0\n0 0 0 0\n' > flat.txt
    printf '1 0 0 5000 0 1 0 0 0 0 1 0' > move.txt
    printf '1 0 0 500\n0 1 0 500\n0 0 1 500\n' > far.txt
}

# What is no mesh, or not wholly: each named for what is wrong with it.
no_meshes() {
    mkdir folder.stl
    : > empty.stl
    head -c 30000 ball.stl > truncated.stl
    { head -c 80 ball.stl; le32 4294967295; tail -c +85 ball.stl; } > huge_count.stl
    { head -c 80 ball.stl; le32 0; } > no_triangles.stl
    { printf '\x81\x82\x83'; head -c 5000 ball.stl; } > random.stl
    printf '<!DOCTYPE html>\n<html><body>404 Not Found</body></html>\n' > page.stl
    with_float ball.stl 0x7fc00000 > nan.stl
    with_float ball.stl 0xff800000 > infinite.stl
    with_float ball.stl 0x7f6fffff > far_away.stl
    head -c 60 <<< $'solid a\n'"$(facet $'vertex 0 0 0\nvertex 1 0 0\n')" > cut.stl
}

# Images and archives; where this build has no archives, what is said of them is not tested.
medical_files() {
    sphere a.stl 2000
    sphere b.stl 500
    expect 0 slice a.stl --spacing 1,1.5,2 --frame ras -o image.nii
    rm image.nii.lamella.json
    expect 0 slice a.stl --spacing 1,1.5,2 --frame ras -o a.h5
    expect 0 slice b.stl --spacing 2,2,2 --subslices 3 --frame ras -o share.h5 -o share.nii
    expect 0 slice b.stl --like image.nii --frame ras -o b.h5
    expect 0 slice a.stl --layer-height 1 -o plain.h5
    local range
    for range in 0:4 4:9 9:; do
        expect 0 slice a.stl --layer-height 1 --layers "$range" -o "plain${range%%:*}.h5"
    done
    expect 0 slice a.stl --spacing 1,1.5,2 --frame ras --layers 4:9 -o image4.h5
    cp a.h5 damaged.h5
    printf 'x' | dd of=damaged.h5 bs=1 seek=15000 conv=notrunc status=none
    head -c 15000 a.h5 > cut.h5
    awk '/^vertex/ {$2 += 500; $3 += 500; $4 += 500} 1' open.stl > far.stl
}

# Meshes in folders, for commands that take several.
folders() {
    mkdir -p many/below many/.hidden many/empty '[old]'
    cp ball.stl many/c.stl
    cp ball.stl many/below/B.STL
    gzip -nc ball.stl > many/a.stl.gz
    cp ball.stl many/.hidden/hidden.stl
    cp ball.stl many/ball
    cp ball.stl '[old]/[a,b].stl'
    ln -s .. many/up
    echo words > many/words.txt
    mkdir mixed
    cp ball.stl mixed/c.stl
    echo junk > mixed/b.obj
}

# manifest NAME LINE...
manifest() { printf '%b\n' "${@:2}" > "$1"; }

# Other names of a.stl's images and numbers, and manifests of outputs that are inputs.
link_names() {
    ln -s . here
    ln image.nii twin.nii
    printf '1\n2\n' > p.meshes.csv
    printf '1 0 0 0\n0 1 0 0\n0 0 1 0\n' > matrix.svg
    manifest list.csv path a.stl many/c.csv
    manifest heights_as_output.csv path,planes,output a.stl,,heights.csv b.stl,heights.csv,o/b.csv
    manifest twice.csv path,output a.stl,o/a.csv b.stl,here/o/a.csv
}

# Two faces, one of which is left out, and a byte too much.
one_ply() {
    printf 'ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 2
property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 0 1\n3 0 1 2\n2 0 1\n#'
}

# Three spheres, a torus in a folder, and a file that is no mesh.
meshes() {
    mkdir -p in/sub
    for i in 1 2 3; do sphere in/s$i.stl ${i}000; done
    expect 0 make torus --triangles 2000 -o in/sub/t.stl
    echo "no mesh" > in/bad.stl
}

# Outputs of two meshes with their records.
organs() {
    mkdir -p in out temporary
    export TMPDIR=$PWD/temporary  # other tests verify at the same time
    sphere in/a.stl 2000
    sphere in/b.stl 500
    expect 0 slice in/a.stl in/b.stl --spacing 1,1.5,2 --frame ras -o out/m.nii.gz -o out/m.seg.nrrd -o out/m.csv -o out/m.jsonl
}

# replaced FILE FROM TO: in a copy that takes the file's place.
replaced() {
    sed "s|$2|$3|" "$1" > .changed && ! cmp -s .changed "$1" || fail "nothing to replace in $1"
    mv .changed "$1"
}

# from_record FROM TO: the record in kept.json with this replaced, as the record of out/m.csv.
from_record() { cp kept.json out/m.csv.lamella.json && replaced out/m.csv.lamella.json "$@"; }

# needs FORMAT: skips the test where this build does not write it.
needs() {
    local -a options=(--spacing 5,5,5 --frame lps)
    [[ $1 != dcm ]] || options+=(--without-ct)
    sphere .needed.stl
    "$lamella" slice .needed.stl "${options[@]}" -o ".needed.$1" > .stdout 2> .stderr ||
        { grep -qE "this build|without DICOM" .stderr && skip "no $1"; fail "no $1"; }
    rm .needed*
}

# A report but for its times, which differ from run to run.
without_times() { sed '/^  "ms": {$/,/^  },\{0,1\}$/d'; }
