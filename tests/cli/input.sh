# What the tool is given: arguments and mesh files; sourced by cli.sh.

test_usage() {
    sphere ball.stl
    local slice=(slice ball.stl)
    expect_failure 2 "subcommand"
    expect_failure 2 "'shred' is not a command" shred ball.stl
    expect_failure 2 "mesh" slice
    expect_failure 2 "--wings" "${slice[@]}" --wings
    expect 0 slice --help
    tr -s ' \n' ' ' < .stdout | grep -q "end of its name: .svg, .nii.gz, .nii, .seg.nrrd, .nrrd, .dcm, .csv, .jsonl, .png, .h5;" ||
        fail "--help does not list the ends of names"
    expect_failure 3 "extra: cannot be opened" "${slice[@]}" extra
    local words
    for words in '--layer-height '{0,-0.1,nan,inf,thin,'0.1 --planes 1'} '--first-height '{'0.1 --planes 1',nan} '--seed 3' \
        '--random-heights '{2:1,0:1,1} '--planes 1,two' '--datum middle' '--side left' '--grid -1' '--normal '{0\,0\,0,1\,2} \
        '--threads '{-1,many} '--band -1' '--progress sometimes'; do
        # shellcheck disable=SC2086
        expect_failure 2 "${words%% *}" "${slice[@]}" $words
    done
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
        expect_failure 2 "mesh: is empty" "$command" ""
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

# with_float FILE BITS: prints a binary file with the first coordinate of the first triangle replaced
with_float() { head -c 96 "$1"; le32 "$2"; tail -c +101 "$1"; }

facet() { printf 'facet normal 0 0 1\nouter loop\n%sendloop\nendfacet\n' "$1"; }

test_bad_input() {
    sphere ball.stl
    mkdir folder.stl
    : > empty.stl
    head -c 30000 ball.stl > truncated.stl
    { head -c 80 ball.stl; le32 4294967295; tail -c +85 ball.stl; } > huge_count.stl
    { head -c 80 ball.stl; le32 0; } > no_triangles.stl
    head -c 5000 /dev/urandom > random.stl
    printf '<!DOCTYPE html>\n<html><body>404 Not Found</body></html>\n' > page.stl
    with_float ball.stl 0x7fc00000 > nan.stl
    with_float ball.stl 0xff800000 > infinite.stl
    with_float ball.stl 0x7f6fffff > far_away.stl
    printf 'solid a\n%s\n' "$(facet $'vertex 0 0 0\nvertex 1 0 0\n')" | head -c 60 > cut.stl
    local file begin command
    for file in missing.stl *.stl; do
        [[ $file != ball.stl ]] || continue
        for command in slice info check; do
            begin=$(now_us)
            expect_failure 3 "$file" "$command" "$file"
            (($(now_us) - begin < 1000000)) || [[ $lamella == */asan/* || $lamella == */tsan/* ]] || fail "$file: over a second"
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
        expect_silent slice ball.stl $format --report report.json
        expect_json report.json "$hash" output_hash
    done
}
