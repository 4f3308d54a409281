#!/usr/bin/env bash
# Snakemake is killed while it slices, with all that it started or by itself, and run again: the files are those of one machine.
source "$(dirname "${BASH_SOURCE[0]}")/support.sh"

workflow=(snakemake --snakefile "$root/tools/cluster/Snakefile" --cores 2 --rerun-incomplete
    --config meshes='meshes/*.stl' results=masks options="${batch_options[*]@Q}")

# run NAME: its log is log.NAME.
run() { "${workflow[@]}" > "log.$1" 2>&1 || fail "$1: $(tail -n 5 "log.$1")"; }

# descendants PID: itself and all below it.
descendants() {
    local child
    echo "$1"
    for child in $(pgrep -P "$1"); do
        descendants "$child"
    done
}

# kill_it all|alone: after the first masks.
kill_it() {
    local main victims
    "${workflow[@]}" > "log.$1" 2>&1 &
    main=$!
    wait_for 120 "some masks" eval "files_in masks 2 || ! kill -0 $main"
    kill -0 "$main" 2> /dev/null || fail "Snakemake ended before it could be killed"
    victims="$main"
    [[ "$1" != all ]] || victims="$(descendants "$main")"
    # shellcheck disable=SC2086
    kill -KILL $victims 2> /dev/null || true
    wait "$main" 2> /dev/null || true
    [[ ! -e masks/results.jsonl ]] || fail "it was killed too late"
}

for victims in all alone; do
    step "killed: $victims"
    kill_it "$victims"
    "${workflow[@]}" --unlock > "log.unlock" 2>&1
    run "again.$victims"
    same one_machine masks
    rm -r masks .snakemake
done

step "a mesh more"
run whole
before="$(stat --format=%Y.%i masks/m0.nii.gz)"
cp meshes/m0.stl meshes/z.stl
run more
[[ "$(stat --format=%Y.%i masks/m0.nii.gz)" == "$before" ]] || fail "what was done is done again"
[[ "$(wc -l < masks/results.jsonl)" == 14 ]] || fail "the results are not those of 14 meshes"
find masks -name 'results.*-of-*' | grep . && fail "parts are left"

step "words that are wrong"
if snakemake --snakefile "$root/tools/cluster/Snakefile" --cores 1 --config meshes='none/*.stl' results=x options=y > log.wrong 2>&1; then
    fail "no meshes are accepted"
fi
grep -q "no mesh is named none/" log.wrong || fail "no meshes: $(tail -n 1 log.wrong)"
echo done
