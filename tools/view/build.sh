#!/usr/bin/env bash
# tools/view/build.sh [FOLDER]: makes FOLDER/view.html (build/view), the page that slices, by emscripten and npm. Where the C++
# build finds it as build/view/view.html, or as -DLAMELLA_VIEW_PAGE=FILE says, it is installed for `lamella view`.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
source tools/packages.sh
install_missing "${page_packages[@]}"
mkdir -p "${1:-build/view}"
folder=$(realpath "${1:-build/view}") root=$PWD
readonly folder root libraries=$folder/libraries
# emscripten 3.1 does not know node's fetch(); its own scripts use Debian's modules.
export NODE_OPTIONS=--no-experimental-fetch NODE_PATH=/usr/share/nodejs

[[ -e $libraries/lib/libzip.a ]] || tools/toolchains/libraries.sh "$libraries" --toolchain "$root/tools/toolchains/wasm.cmake" > "$folder/log" 2>&1 ||
    stop "zlib, expat and libzip could not be built: see $folder/log"
# Debian's emscripten aligns memory to 8 bytes, and 128-bit integers of the compiler want 16.
cmake -S . -B "$folder/wasm" -G Ninja --toolchain "$root/tools/toolchains/wasm.cmake" -DCMAKE_FIND_ROOT_PATH="$libraries" \
    -DCMAKE_BUILD_TYPE=Release -DLAMELLA_PARALLEL=std -DLAMELLA_PORTABLE=ON -DLAMELLA_BUILD_{SHARED,MEDICAL,TOOLS,BENCH,TESTS,PYTHON}=OFF \
    -DLAMELLA_BUILD_IO=ON -DCMAKE_CXX_COMPILER_LAUNCHER="$(command -v ccache || true)" > "$folder/log" || stop "see $folder/log"
cmake --build "$folder/wasm" --target lamella_io > "$folder/log" || stop "see $folder/log"

em++ -std=c++20 -O2 -fwasm-exceptions -ffp-contract=off -Wall -Wextra -Werror -Iinclude -Iengine -I"$libraries/include" \
    tools/view/core/*.cpp "$folder"/wasm/engine/liblamella{_io,}.a "$libraries"/lib/lib{expat,zip,z}.a -lworkerfs.js \
    -sALLOW_MEMORY_GROWTH=1 -sMAXIMUM_MEMORY=4GB -sMODULARIZE=1 -sEXPORT_NAME=createCore -sENVIRONMENT=worker,node -sDYNAMIC_EXECUTION=0 \
    -sEXPORTED_RUNTIME_METHODS=FS,WORKERFS,ccall -sINCOMING_MODULE_JS_API=instantiateWasm,progress,wasmBinary --no-entry \
    -sEXPORTED_FUNCTIONS=_malloc,_free -o "$folder/core.js"

# licence NAME FILE
licence() { printf '%s\n\n%s\n\n\n' "$1" "$(cat "$2")"; }
{
    licence lamella LICENSE
    licence "expat, which reads 3MF" "$(echo "$libraries"/sources/expat-*/expat/COPYING)"
    licence "libzip, which opens 3MF" "$(echo "$libraries"/sources/libzip-*/LICENSE)"
    licence "zlib" "$(echo "$libraries"/sources/zlib-*/LICENSE)"
    licence "emscripten, musl, LLVM's libraries" /usr/share/doc/emscripten/copyright
    licence "fast_float" /usr/share/doc/libfast-float-dev/copyright
    licence "JSON for Modern C++" /usr/share/doc/nlohmann-json3-dev/copyright
} > "$folder/licences.txt"
cd tools/view
[[ node_modules/.package-lock.json -nt package-lock.json ]] || npm ci --no-audit --no-fund --silent --ignore-scripts > "$folder/log" 2>&1 ||
    stop "npm ci: see $folder/log"
node_modules/.bin/tsc -p .
node page.mjs "$folder"
