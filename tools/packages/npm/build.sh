#!/usr/bin/env bash
# npm/build.sh FOLDER: makes FOLDER/lamella-VERSION.tgz, the core as WebAssembly with typed calls, by emscripten and npm.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../../.."
source tools/packages.sh
install_missing "${page_packages[@]}"
mkdir -p "$1/npm"
folder=$(realpath "$1") root=$PWD
logged() { "$@" > "$folder/npm.log" 2>&1 || stop "$1 failed: see $folder/npm.log"; }
export NODE_OPTIONS=--no-experimental-fetch NODE_PATH=/usr/share/nodejs  # as in tools/view/build.sh

# A Release of the engine, as for the page, is a quarter smaller, but takes up to twice as long for regions.
logged cmake -S . -B "$folder/wasm" -G Ninja --toolchain "$root/tools/toolchains/wasm.cmake" -DLAMELLA_BUILD_{SHARED,IO,TESTS}=OFF \
    -DLAMELLA_PARALLEL=std -DLAMELLA_PORTABLE=ON -DCMAKE_BUILD_TYPE=Speed -DCMAKE_CXX_{FLAGS_SPEED="-O2 -DNDEBUG",COMPILER_LAUNCHER="$(command -v ccache || true)"}
logged cmake --build "$folder/wasm" --target lamella
logged em++ -std=c++20 -O3 -fwasm-exceptions -ffp-contract=off -Wall -Wextra -Werror -Iinclude -Iengine tools/packages/npm/core.cpp \
    "$folder/wasm/engine/liblamella.a" -sSTANDALONE_WASM=1 -sALLOW_MEMORY_GROWTH=1 -sMAXIMUM_MEMORY=4GB --no-entry \
    -sEXPORTED_FUNCTIONS=_malloc,_free -o "$folder/npm/lamella.wasm"
[[ -e tools/view/node_modules/.package-lock.json ]] || (cd tools/view && logged npm ci --no-audit --no-fund --ignore-scripts)
logged tools/view/node_modules/.bin/tsc tools/packages/npm/src/*.ts --outDir "$folder/npm" --declaration --stripInternal --target es2022 --module esnext \
    --moduleResolution bundler --lib es2022,dom,dom.iterable --strict --noUnusedLocals --noImplicitReturns --noUncheckedIndexedAccess
cp LICENSE tools/packages/npm/{README.md,package.json} "$folder/npm"
cp /usr/share/doc/emscripten/copyright "$folder/npm/licences.txt"  # and of musl and LLVM's libraries
cd "$folder/npm"
sed -i "s/0\.0\.0/$(lamella_version "$root")/" package.json
logged npm pack --pack-destination "$folder"
