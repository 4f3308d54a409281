#!/usr/bin/env bash
# Installs what is missing, builds, makes a sample mesh, slices it and leaves an SVG, a picture and a report in build/demo.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source tools/packages.sh

readonly triangles=1000000
readonly height_mm=150
readonly layer_height_mm=0.2
readonly out=build/demo

install_missing "${build_packages[@]}" "${picture_packages[@]}"

generator=()
[[ -e build/CMakeCache.txt ]] || generator=(-G Ninja)
cmake -S . -B build "${generator[@]}" -DCMAKE_BUILD_TYPE=Release > /dev/null
cmake --build build --parallel --target lamella_cli

mkdir -p "$out"
if [[ ! -e "$out/bone.stl" || build/tools/lamella -nt "$out/bone.stl" ]]; then
    build/tools/lamella make bone --triangles "$triangles" --height "$height_mm" -o "$out/bone.stl"
fi
echo
build/tools/lamella slice "$out/bone.stl" --layer-height "$layer_height_mm" -o "$out/bone.svg" --report "$out/report.json"
rsvg-convert --unlimited --width 1200 "$out/bone.svg" --output "$out/bone.png"
echo "picture   $out/bone.png"
