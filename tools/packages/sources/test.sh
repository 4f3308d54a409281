#!/usr/bin/env bash
# sources/test.sh TOOL FOLDER: README's program fetches the sources in FOLDER, as README says, where CMake finds no package. It must
# slice its mesh as TOOL does.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../../.." && pwd)
source "$root/tools/packages.sh"
tool=$(realpath "$1") folder=$(realpath "$2")
host=$(mktemp -d)
trap 'rm -rf "$host"' EXIT

# block LANGUAGE NUMBER: of README.md.
block() { awk -v fence="\`\`\`$1" -v number="$2" '/^```/ { on = !on && $0 == fence && ++at == number; next } on' "$root/README.md"; }

block cpp 1 | sed 's/^    return 0;$//; s/^}$/    std::printf("%016llx\\n", static_cast<unsigned long long>(sliced->hash()));\n}/' > "$host/app.cpp"
mapfile -t numbers < <(sed -n '/soup = {/,/};/p' "$host/app.cpp" | sed 's/.*= {//' | grep -oE '[0-9]+')
corner='vertex %s %s %s\n'
printf "solid\nfacet normal 0 0 0\nouter loop\n$corner$corner${corner}endloop\nendfacet\n" "${numbers[@]}" | sed '1n; /^solid$/d; $a endsolid' > "$host/mesh.stl"
{
    printf '%s\n' 'cmake_minimum_required(VERSION 3.21)' 'project(app LANGUAGES CXX)' 'set(LAMELLA_PARALLEL std)' 'add_executable(app app.cpp)'
    block cmake 2
} > "$host/CMakeLists.txt"
cp "$folder"/lamella-*-sources.tar.gz "$host"
cd "$host"
{
    cmake -S . -B build -DCMAKE_BUILD_TYPE=Release -DCMAKE_DISABLE_FIND_PACKAGE_{PkgConfig,TBB,ZLIB,EXPAT}=ON \
        -DCMAKE_CXX_COMPILER_LAUNCHER="$(command -v ccache || true)" &&
        cmake --build build --target app --parallel "$(nproc)"
} > log 2>&1 || stop "README's program does not build: $(tail -n 20 log)"
hash=$("$tool" slice mesh.stl --layer-height 1 --hash | sed -n 's/^hash *//p')
[[ ${#hash} == 16 && $(build/app) == *"40 layers, 40 contours"*"$hash" ]] || stop "README's program slices something else than $hash: $(build/app | tail -n 2)"
echo "fetched by CMake, README's program slices the same: $hash"
