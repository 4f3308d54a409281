#!/usr/bin/env bash
# run_all.sh FOLDER SAMPLE PREFIX CC: runs the programs in FOLDER, and one that pkg-config finds its library for.
set -euo pipefail
folder=$1 sample=$2 prefix=$3 cc=$4
source_folder=$(dirname "${BASH_SOURCE[0]}")
readonly expected="40 layers, 40 contours"

check() {
    local printed
    printed=$("$@" "$sample")
    [[ "$printed" == "$expected" ]] || { echo "$1 printed: $printed"; exit 1; }
}

for program in app app_static app_shared_clash app17; do
    check "$folder/$program"
done

pc=$(dirname "$(find "$prefix" -name lamella_c.pc)")
export PKG_CONFIG_PATH=$pc
# shellcheck disable=SC2046
"$cc" -std=c99 "$source_folder/app.c" $(pkg-config --cflags --libs lamella_c) -o "$folder/app_pkg_config"
LD_LIBRARY_PATH=$(pkg-config --variable=libdir lamella_c) check "$folder/app_pkg_config"
echo "all programs cut the sample"
