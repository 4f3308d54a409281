#!/usr/bin/env bash
# demo.sh [TRIANGLES]: builds the command-line tool, slices a generated bone into layers, and draws a cut along its length. All
# files go to build/demo.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source tools/packages.sh

readonly triangles=${1:-1000000}
readonly out=build/demo
readonly lamella=build/tools/lamella

# step WHAT COMMAND...: prints what is done and how long it took; the command's output goes to a log.
step() {
    local start=$SECONDS
    echo "$1"
    "${@:2}" >> "$out/log.txt" 2>&1 || stop "$2 failed; its output is in $out/log.txt"
    echo "    $((SECONDS - start)) s"
}

mkdir -p "$out"
: > "$out/log.txt"
install_missing "${build_packages[@]}" "${picture_packages[@]}"
generator=()
[[ -e build/CMakeCache.txt ]] || generator=(-G Ninja)
step "Configuring" cmake -S . -B build "${generator[@]}" -DCMAKE_BUILD_TYPE=Release -DLAMELLA_BUILD_BENCH=OFF
step "Building lamella (the first time, a few minutes)" cmake --build build --parallel "$(nproc)" --target lamella_cli
step "Making a bone of $triangles triangles, 150 mm tall" "$lamella" make bone --triangles "$triangles" --height 150 -o "$out/bone.stl"
echo "Slicing it into layers of 0.2 mm"
"$lamella" slice "$out/bone.stl" --layer-height 0.2 -o "$out/bone.svg" --report "$out/report.json"
# The matrix's rows are the picture's axes: along the bone, across it, and the direction of slicing. The plane is 1 mm
# off the mesh's z-axis, because a cut through the axis itself shows little of the marrow cavity.
printf '0 0 1 0\n1 0 0 0\n0 1 0 0\n' > "$out/lengthwise.txt"
step "Cutting it once along its length" "$lamella" slice "$out/bone.stl" --transform "$out/lengthwise.txt" --planes 1 -o "$out/cut.svg"
step "Drawing that cut" rsvg-convert --unlimited --width 1400 "$out/cut.svg" --output "$out/cut.png"

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
