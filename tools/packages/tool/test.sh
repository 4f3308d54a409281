#!/usr/bin/env bash
# tool/test.sh TOOL FOLDER: as root, runs the programs for Linux and Windows that are in FOLDER.
#
# TOOL is lamella of the sources, whose hash and files the programs must give: the one in a folder where nothing else is, the
# other under wine. It has no HDF5.
set -euo pipefail
shopt -s inherit_errexit
tool=$(realpath "$1")
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../../.." && pwd)
folder=$(realpath "$2")
readonly tool root folder
source "$root/tools/packages.sh"
at=$(mktemp -d)
readonly at
export WINEPREFIX=$at/wine WINEDEBUG=-all
trap '/usr/lib/wine/wineserver64 -k || true; rm -rf "$at"' EXIT

in_linux() { TMPDIR=/ chroot "$at/linux" /lamella "$@"; }
in_windows() { (cd "$at/windows" && /usr/lib/wine/wine64 lamella.exe "$@" | tr -d '\r'); }
sources() { (cd "$at/sources" && "$tool" "$@"); }

# use RUN FOLDER: runs a program by the function of that name, which works in FOLDER, and prints hash and checksums.
use() {
    "$1" make bone --triangles 20000 -o bone.stl > /dev/null
    "$1" slice bone.stl --layer-height 0.2 --hash | grep '^hash'
    "$1" slice bone.stl --layer-height 2 --screen "Prusa SL1" -o bone.svg --to svg,cli,dxf,vtp,sl1,3mf-slices > /dev/null
    "$1" slice bone.stl --spacing 1,1,1 --frame ras -o bone.nii.gz --to nii.gz,seg.nrrd,seg.dcm,png,csv --without-ct > /dev/null
    cp "$root/tests/sloppy/files/3mf_zip64.3mf" "$2/given.3mf"
    "$1" slice given.3mf --hash | grep '^hash'
    (cd "$2" && rm bone.*.json && sha256sum bone.*)  # records name the time
}

mkdir -p "$at"/{linux,windows,sources,packed}
tar -xzf "$folder"/lamella-*-linux-*.tar.gz -C "$at/packed"
/usr/bin/python3 -m zipfile -e "$folder"/lamella-*-windows-*.zip "$at/packed"
mv "$at"/packed/lamella-*-linux-*/bin/lamella "$at/linux"
mv "$at"/packed/lamella-*-windows-*/bin/lamella.exe "$at/windows"
[[ $(ldd "$at/linux/lamella" 2>&1) == *"not a dynamic executable"* ]] || stop "the program for Linux is not static"
for licence in "$at"/packed/*/licences; do
    [[ -s $licence/lamella && -s $licence/zlib ]] || stop "$licence lacks licences"
done

in_windows --version > /dev/null 2>&1  # what wine says when it begins

use sources "$at/sources" > "$at/expected"
for system in linux windows; do
    use "in_$system" "$at/$system" > "$at/given"
    diff "$at/expected" "$at/given" || stop "the program for $system writes something else"
    echo "the program for $system writes the same $(grep -c bone "$at/given") files: $(head -1 "$at/given")"
done

in_linux slice bone.stl -o bone.h5 > /dev/null
said=$(in_windows slice bone.stl -o bone.h5 2>&1 || true)
[[ $said == *"bone.h5': this build has no HDF5" && $said != *$'\n'* ]] || stop "an archive is refused by: $said"
