#!/usr/bin/env bash
# tools/packages/build.sh FOLDER NAME...          makes packages in FOLDER: sources, python, deb, npm, tool; or all
# tools/packages/build.sh --test FOLDER NAME...   installs them where the sources are not: they must slice as build/tools/lamella does
#
# python is a wheel and a source distribution, tool a program for Linux and one for Windows. sources and deb are of what is
# committed, the others of the files as they are. Missing packages of Debian are installed.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
source "$root/tools/packages.sh"
step=(build)
if [[ ${1:-} == --test ]]; then
    step=(test "$root/build/tools/lamella")
    [[ -x ${step[1]} ]] || stop "${step[1]} is missing: tools/test.sh builds it"
    shift
fi
(($# >= 2)) || stop "usage: $0 [--test] FOLDER NAME..."
mkdir -p "$1"
folder=$(realpath "$1")
names=("${@:2}")
[[ $2 != all ]] || names=(sources python tool deb npm)  # the program for Linux is of the wheel
for name in "${names[@]}"; do
    [[ -x $root/tools/packages/$name/build.sh ]] || stop "no such package: $name"
    begin=$SECONDS
    "$root/tools/packages/$name/${step[0]}.sh" "${step[@]:1}" "$folder"
    echo "$name: ${step[0]} took $((SECONDS - begin)) s"
done
