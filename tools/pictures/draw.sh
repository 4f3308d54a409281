#!/usr/bin/env bash
# Draws the picture in README.md: a bone of four million triangles, cut once along its length.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
source tools/packages.sh
install_missing "${build_packages[@]}" "${picture_packages[@]}"

cmake -S . -B build -DCMAKE_BUILD_TYPE=Release -DLAMELLA_BUILD_BENCH=OFF > /dev/null
cmake --build build --parallel --target lamella_cli > /dev/null

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
printf '0 0 1 0\n1 0 0 0\n0 1 0 0\n' > "$folder/lengthwise.txt" # the picture's axes: along the bone, across it, and the direction of slicing
build/tools/lamella make bone --triangles 4000000 --height 150 -o "$folder/bone.stl"
build/tools/lamella slice "$folder/bone.stl" --transform "$folder/lengthwise.txt" --planes 1 -o "$folder/bone.svg"
rsvg-convert --width 1400 "$folder/bone.svg" --output tools/pictures/bone.png
