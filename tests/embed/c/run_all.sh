#!/usr/bin/env bash
# run_all.sh FOLDER SAMPLE PREFIX README CC CXX [PYTHON]: runs the programs in FOLDER, which CMake has built, those that are
# built here by what pkg-config says, and one in Python.
set -euo pipefail
folder=$1 sample=$2 prefix=$3 readme=$4 cc=$5 cxx=$6 python=${7:-}
source_folder=$(dirname "${BASH_SOURCE[0]}")
readonly expected="40 layers, 40 contours"

check() {
    local printed
    printed=$("$@" "$sample") || { echo "$1 failed"; exit 1; }
    [[ "${printed##*$'\n'}" == "$expected" ]] || { echo "$1 printed: $printed"; exit 1; }
}

for program in app app_static app17; do
    check "$folder/$program"
done

pc=$(find "$prefix" -name lamella_c.pc)
export PKG_CONFIG_PATH=${pc%/*}
libraries=$(pkg-config --variable=libdir lamella_c)
shown=$(sed -n '/^```python$/,/^```$/p' "$(dirname "$readme")/tools/docs/embedding.md" | sed '/^```/d')
[[ -n $shown && $(< "$source_folder/app.py") == *"$shown"* ]] || { echo "embedding.md shows other Python than app.py has"; exit 1; }
[[ -z $python ]] || check "$python" "$source_folder/app.py" "$prefix/include/lamella/lamella.h" "$libraries/liblamella_c.so"

# build NAME PACKAGE COMPILER...: the last word is the source.
build() {
    local program=$folder/$1 package=$2
    shift 2
    # shellcheck disable=SC2046  # words of flags
    "$@" $(pkg-config --cflags --libs "$package") "-Wl,-rpath,$(pkg-config --variable=libdir lamella_c)" -o "$program"
}
# shellcheck disable=SC2016
sed -n '/^```cpp$/,/^```$/p' "$readme" | sed '/^```/d' > "$folder/app20.cpp"
build pkg_config_c99 lamella_c "$cc" -std=c99 -pedantic-errors "$source_folder/app.c"
build pkg_config_c++17 lamella_c "$cxx" -std=c++17 "$folder/app17.cpp"
build pkg_config_static_c++17 lamella "$cxx" -std=c++17 "$folder/app17.cpp"
build pkg_config_static_c++20 lamella "$cxx" -std=c++20 "$folder/app20.cpp"
for program in pkg_config_c99 pkg_config_c++17 pkg_config_static_c++17 pkg_config_static_c++20; do
    check "$folder/$program"
done
echo "all programs cut the sample"
