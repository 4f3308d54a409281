# The commands beside slice; sourced by cli.sh.

test_make() {
    local shape
    for shape in sphere torus gyroid bone prism; do
        expect 0 make "$shape" --triangles 20000 -o "$shape.stl"
        expect_line stdout '^closed  *yes' info "$shape.stl"
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
    expect_members open.json 'findings boundary_edges count=3' 'findings boundary_loops places 0 edges=3' clean=OFF \
        'file format=STL'
    grep -q '^element vertex 7$' open.ply || fail "marks: not seven points"
    grep -q '^element edge 3$' open.ply || fail "marks: not three edges"
    cp .stdout words
    expect 0 check open.stl --threads 1 --report - --marks again.ply
    cmp <(without_times < .stdout) <(without_times < open.json) || fail "another report on one thread"
    local stage
    for stage in read parse measure faces edges joints shells meeting gaps write total report; do
        json_value open.json ms "$stage" > .value || exit 1
    done
    rm .value
    cmp .stderr words || fail "other words on one thread"
    cmp open.ply again.ply || fail "other marks on one thread"
    grep -qE '^self-|^duplicate|^cracks' words && fail "kinds that were not found are listed"
    [[ $(sed -n 2p words) =~ ^boundary\ edges\ +3$ ]] || fail "what was found does not come first"
    expect 0 check open.stl --all
    grep -qE '^cracks  *0$' .stdout || fail "--all leaves kinds out"
    expect_line stdout '^  ... and 2 more$' check open.stl --places 1 --tolerance 0
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
