#!/usr/bin/env bash
# Installs what is missing, builds with GCC and with Clang, checks format and style, and runs every test: under the sanitizers
# first, then as released. Ends with the summary of that last run.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source tools/packages.sh

readonly jobs=$(nproc)

stage() { printf '\n== %s (%d s so far)\n' "$1" "$SECONDS"; }

# configure FOLDER OPTION...
configure() {
    local folder=$1 generator=()
    shift
    [[ -e "$folder/CMakeCache.txt" ]] || generator=(-G Ninja)
    cmake -S . -B "$folder" "${generator[@]}" "$@" > /dev/null
}

# Debug, so that assertions hold the invariants to account; optimised a little, and ten sources compiled as one, so that it
# ends today.
configure_sanitizer() {
    configure "$@" -DCMAKE_BUILD_TYPE=Debug -DCMAKE_CXX_FLAGS_DEBUG="-O1 -g1" -DCMAKE_UNITY_BUILD=ON -DCMAKE_UNITY_BUILD_BATCH_SIZE=10 \
        -DLAMELLA_BUILD_BENCH=OFF
}

# quietly LOG COMMAND...: only a failure shows what the command had to say.
quietly() {
    local log=$1
    shift
    "$@" > "$log" 2>&1 || {
        cat "$log"
        return 1
    }
}

build() { quietly "$1/build.log" cmake --build "$1" --parallel "$jobs"; }

# summary LOG: what ctest ends with, the skipped tests among it.
summary() { sed -n '/tests passed/,$p' "$1"; }

# All but those labelled "long" and "paper".
run_tests() { ctest --test-dir "$1" --label-exclude 'long|paper' --parallel "$jobs" --output-on-failure "${@:2}"; }

stage "packages"
install_missing "${build_packages[@]}" "${check_packages[@]}" "${picture_packages[@]}"

stage "format"
find engine include tests bench tools -name '*.[ch]pp' -print0 | xargs -0 clang-format --dry-run -Werror

stage "release build"
configure build -DCMAKE_BUILD_TYPE=Release -DLAMELLA_WERROR=ON
build build

stage "Clang build, address and undefined-behaviour sanitizers"
configure_sanitizer build/asan -DCMAKE_CXX_COMPILER=clang++ -DLAMELLA_SANITIZE=address -DLAMELLA_WERROR=ON -DCMAKE_EXPORT_COMPILE_COMMANDS=ON
build build/asan

# Every source of the engine, the tools and the oracle with the headers that they include; not the other tests, nor bench/.
stage "clang-tidy"
# The static analyser among its checks takes as long as all others: TIDY_CHECKS= (empty) runs it too.
run-clang-tidy -quiet -j "$jobs" -checks="${TIDY_CHECKS--clang-analyzer-*}" -p build/asan \
    "^$PWD/(build/asan/)?(engine|tools|tests/oracle|tests/CMakeFiles/lamella_test_support[.]dir)/" > build/tidy.log 2>&1 || {
    grep -A 5 -E '(error|warning):' build/tidy.log || cat build/tidy.log
    exit 1
}

stage "tests under the address and undefined-behaviour sanitizers"
UBSAN_OPTIONS=print_stacktrace=1 quietly build/asan/tests.log run_tests build/asan
summary build/asan/tests.log

# std::thread for oneTBB, whose Debian build the sanitizer cannot see into. Real meshes take it minutes and no other path.
stage "GCC, thread sanitizer"
configure_sanitizer build/tsan -DLAMELLA_SANITIZE=thread -DLAMELLA_PARALLEL=std
build build/tsan
stage "tests under the thread sanitizer"
TSAN_OPTIONS=halt_on_error=1 quietly build/tsan/tests.log run_tests build/tsan --exclude-regex shared_models
summary build/tsan/tests.log

stage "tests of the release build"
run_tests build
