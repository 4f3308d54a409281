#!/usr/bin/env bash
# examples.sh README TOOL: runs README's examples of the command line, which are its blocks in bash, in an empty folder.
source "$(dirname "${BASH_SOURCE[0]}")/page.sh" "$@" masks/bone{1..12}.{nii.gz,csv,png} masks/results.jsonl checks.json faults.ply bone.stl gyroid.stl
[[ $(grep -c lamella examples) -ge 4 ]] || { echo "README shows fewer than four commands"; exit 1; }
grep -q "12: 12 done, 0 unchanged, 0 failed" output || { cat output; echo "expected twelve meshes done"; exit 1; }
[[ $(grep -c '^contours ' output) == 2 && $(grep -c '(1 thread,' output) == 1 ]] || {
    cat output
    echo "expected two slices, one of them on 1 thread"
    exit 1
}
