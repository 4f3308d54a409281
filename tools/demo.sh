#!/usr/bin/env bash
# Builds the command-line tool, slices a generated bone into layers, and draws a cut along its length. All files go to
# build/demo.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source tools/packages.sh

readonly triangles=1000000
readonly height_mm=150
readonly layer_height_mm=0.2
readonly out=build/demo
readonly lamella=build/tools/lamella

# step WHAT COMMAND...: prints what is done, does it, and prints how long it took.
step() {
    local what=$1 start=$EPOCHREALTIME
    shift
    echo "$what"
    "$@"
    awk -v start="$start" -v end="$EPOCHREALTIME" 'BEGIN { printf "    %.1f s\n", end - start }'
}

# quietly COMMAND...: sends the output to a log. If the command fails, the error message names the log.
quietly() {
    "$@" >> "$out/log.txt" 2>&1 || stop "$1 failed; its output is in $out/log.txt"
}

build() {
    local generator=()
    [[ -e build/CMakeCache.txt ]] || generator=(-G Ninja)
    quietly cmake -S . -B build "${generator[@]}" -DCMAKE_BUILD_TYPE=Release -DLAMELLA_BUILD_BENCH=OFF
    quietly cmake --build build --parallel --target lamella_cli
}

make_bone() { "$lamella" make bone --triangles "$triangles" --height "$height_mm" -o "$out/bone.stl" > /dev/null; }

slice_into_layers() {
    "$lamella" slice "$out/bone.stl" --layer-height "$layer_height_mm" -o "$out/bone.svg" --report "$out/report.json"
}

# The matrix's rows are the picture's axes: along the bone, across it, and the direction of slicing. The plane is 1 mm
# off the mesh's z-axis, because a cut through the axis itself shows little of the marrow cavity.
cut_along() {
    printf '0 0 1 0\n1 0 0 0\n0 1 0 0\n' > "$out/lengthwise.txt"
    "$lamella" slice "$out/bone.stl" --transform "$out/lengthwise.txt" --planes 1 -o "$out/cut.svg" > /dev/null
}

draw() { quietly rsvg-convert --unlimited --width 1400 "$out/cut.svg" --output "$out/cut.png"; }

mkdir -p "$out"
: > "$out/log.txt"
install_missing "${build_packages[@]}" "${picture_packages[@]}"
step "Building lamella (the first time, a few minutes)" build
if [[ ! -e "$out/bone.stl" || "$lamella" -nt "$out/bone.stl" ]]; then
    step "Making a bone of $triangles triangles, $height_mm mm tall" make_bone
fi
step "Slicing it into layers of $layer_height_mm mm" slice_into_layers
step "Cutting it once along its length" cut_along
step "Drawing that cut" draw

cat << END

Files made
    $out/cut.png       the cut along the bone (look at this first)
    $out/cut.svg       the same, as outlines in mm
    $out/bone.svg      all layers, one group each
    $out/report.json   counts, times, volumes, and the parts of the mesh that no layer shows
    $out/bone.stl      the mesh

What to try next
    $lamella slice $out/bone.stl --normal 1,0,1 --layer-height 5 -o oblique.svg
    $lamella check $out/bone.stl
    $lamella slice --help
END
