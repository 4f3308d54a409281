#!/usr/bin/env bash
# tools/packages/build.sh FOLDER NAME...          makes packages in FOLDER: sources, wheel, sdist, deb, npm, tool-linux, tool-windows
# tools/packages/build.sh --test FOLDER NAME...   installs them where the sources are not, and slices the same hash there
#
# `deb` and `sources` take what is committed, the others the files as they are. Missing packages of Debian are installed.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
source "$root/tools/packages.sh"
step=build
[[ ${1:-} != --test ]] || { step=test && shift; }
(($# >= 2)) || stop "usage: $0 [--test] FOLDER NAME..."
mkdir -p "$1"
folder=$(realpath "$1")
version=$(lamella_version "$root")

# test_sources: a project of another folder fetches them, and finds no package.
test_sources() {
    local -r host=$folder/test-sources
    rm -rf "$host"
    mkdir "$host"
    awk '/^```cpp/ { on = 1; next } /^```/ { on = 0 } on' "$root/README.md" > "$host/app.cpp"
    {
        printf '%s\n' 'cmake_minimum_required(VERSION 3.21)' 'project(app LANGUAGES CXX)' 'set(LAMELLA_PARALLEL std)' 'add_executable(app app.cpp)'
        awk '/^```cmake/ { on = ++at == 2; next } /^```/ { on = 0 } on' "$root/README.md" | sed "s|URL [^)]*|URL $folder/lamella-$version-sources.tar.gz|"
    } > "$host/CMakeLists.txt"
    cmake -S "$host" -B "$host/build" -DCMAKE_BUILD_TYPE=Release -DCMAKE_PREFIX_PATH=/nowhere -DCMAKE_FIND_USE_CMAKE_SYSTEM_PATH=OFF > "$host/log" || stop "see $host/log"
    cmake --build "$host/build" --target app --parallel "$(nproc)" > "$host/log" || stop "see $host/log"
    [[ $("$host/build/app") == *"40 layers, 40 contours"* ]] || stop "the fetched library slices something else"
}

for name in "${@:2}"; do
    case $step-$name in
        build-sources) git -C "$root" archive --prefix="lamella-$version/" -o "$folder/lamella-$version-sources.tar.gz" HEAD ;;
        test-sources) test_sources ;;
        *-deb | *-npm) "$root/tools/packages/$name/$step.sh" "$folder" ;;
        *-wheel | *-sdist) "$root/tools/packages/python/$step.sh" "$name" "$folder" ;;
        *-tool-linux | *-tool-windows) "$root/tools/packages/tool/$step.sh" "${name#tool-}" "$folder" ;;
        *) stop "no such package: $name" ;;
    esac
done
