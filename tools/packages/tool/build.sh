#!/usr/bin/env bash
# tool/build.sh FOLDER: makes the tool as one file that needs nothing, with its licences: lamella-VERSION-linux-PROCESSOR.tar.gz
# there, which is the wheel's, and lamella-VERSION-windows-x86_64.zip, by mingw-w64, which has no HDF5.
set -euo pipefail
shopt -s inherit_errexit
cd "$(dirname "${BASH_SOURCE[0]}")/../../.."
source tools/packages.sh
source tools/packages/licences.sh

folder=$(realpath "$1")
version=$(lamella_version .)
readonly folder version work=$folder/tool of_windows='(kernel32|msvcrt|advapi32|bcrypt|shell32|user32|ole32)\.dll'

# add_page FOLDER: that of `lamella view`, where it was made. The tool is in FOLDER/bin.
add_page() { [[ ! -e build/view/view.html ]] || install -D -m 644 build/view/view.html "$1/share/lamella/view.html"; }

make_linux() {
    local -r name=lamella-$version-linux-$(uname -m)
    local -r made=$folder/python/unpacked/lamella-$version/lamella/bin/lamella
    [[ -e $made && -z $(find CMakeLists.txt engine include tools -newer "$made" -print -quit) ]] || tools/packages/python/build.sh "$folder"
    rm -rf "${work:?}/$name"
    copy_licences "$folder/libraries" "$work/$name/licences" libssl-dev libcli11-dev gcc-12-base libc6
    install -D "$made" "$work/$name/bin/lamella"
    add_page "$work/$name"
    ! objdump -p "$work/$name/bin/lamella" | grep -E 'NEEDED|INTERP' || stop "the program is not static"
    tar -czf "$folder/$name.tar.gz" -C "$work" --owner=0 --group=0 "$name"
}

build_windows() {
    local -r toolchain=$PWD/tools/toolchains/mingw.cmake libraries=$work/windows-libraries
    [[ -e $libraries/lib/libpng.a ]] || MORE=libpng1.6 tools/toolchains/libraries.sh "$libraries" --toolchain "$toolchain" || return
    cmake -S . -B "$work/windows" -G Ninja --toolchain "$toolchain" -DCMAKE_FIND_ROOT_PATH="$libraries" -DCMAKE_BUILD_TYPE=Release \
        -DCMAKE_CXX_COMPILER_LAUNCHER="$(command -v ccache || true)" -DLAMELLA_PARALLEL=std \
        -DLAMELLA_BUILD_{SHARED,TESTS,BENCH,PYTHON}=OFF || return
    cmake --build "$work/windows" --target lamella_cli
}

make_windows() {
    local -r name=lamella-$version-windows-x86_64
    local others
    install_missing "${windows_packages[@]}"
    mkdir -p "$work"
    build_windows > "$work/log" 2>&1 || stop "the program could not be built: see $work/log"
    rm -rf "${work:?}/$name"
    copy_licences "$work/windows-libraries" "$work/$name/licences" libcli11-dev gcc-mingw-w64-base mingw-w64-x86-64-dev
    mkdir -p "$work/$name/bin"
    x86_64-w64-mingw32-strip -o "$work/$name/bin/lamella.exe" "$work/windows/tools/lamella.exe"
    add_page "$work/$name"
    others=$(x86_64-w64-mingw32-objdump -p "$work/$name/bin/lamella.exe" | sed -n 's/.*DLL Name: //p' | grep -ivxE "$of_windows" || true)
    [[ -z $others ]] || stop "the program needs ${others//$'\n'/ }"
    rm -f "$folder/$name.zip"
    (cd "$work" && /usr/bin/python3 -m zipfile -c "$folder/$name.zip" "$name")
}

make_linux
make_windows
