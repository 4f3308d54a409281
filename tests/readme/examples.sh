#!/usr/bin/env bash
# examples.sh README TOOL: runs README's examples of the command line, which are its blocks in bash, in an empty folder.
set -euo pipefail
readme=$(realpath "$1")
tool=$(realpath "$2")

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"

sed -n '/^```bash$/,/^```$/p' "$readme" | sed '/^```/d' > examples
[[ $(grep -c lamella examples) -ge 4 ]] || { echo "README shows fewer than four commands"; exit 1; }
PATH=$(dirname "$tool"):$PATH bash -eu examples > output

for made in masks/bone{1..12}.{nii.gz,csv,png} masks/results.jsonl checks.json faults.ply bone.stl gyroid.stl; do
    [[ -s "$made" ]] || { echo "no $made was written"; exit 1; }
done
grep -q "12: 12 done, 0 unchanged, 0 failed" output || { cat output; echo "expected twelve meshes done"; exit 1; }
[[ $(grep -c '^contours ' output) == 2 && $(grep -c '(1 thread,' output) == 1 ]] || {
    cat output
    echo "expected two slices, one of them on 1 thread"
    exit 1
}
