#!/usr/bin/env bash
# tools/test.sh           builds the release and runs its tests
# tools/test.sh --core    builds the engine alone, without readers, and runs its own tests
# tools/test.sh NAME...   builds the release and runs the tests whose names contain one of the words
# tools/test.sh --platforms [TARGET...]   builds for other systems and runs what is built: see tools/platforms.sh
# tools/test.sh --all     also runs the thorough tests (exact judges, other readers, the Python package), checks format and
#                         style, runs the tests under sanitizers, and the golden slices on other systems, by emulators
#
# Installs missing packages. Prints the summary of the release's tests last.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source tools/packages.sh

readonly jobs=$(nproc)

stage() { printf '\n== %s (%d s so far)\n' "$1" "$SECONDS"; }

# configure FOLDER OPTION...
configure() {
    local folder=$1 extra=()
    shift
    [[ -e "$folder/CMakeCache.txt" ]] || extra=(-G Ninja)
    if command -v ccache > /dev/null; then
        extra+=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
        # Asked by what it includes: what a precompiled header was made from must be the same byte by byte, comments too.
        export CCACHE_DEPEND=1 CCACHE_BASEDIR=$PWD
        export CCACHE_SLOPPINESS=pch_defines,time_macros,include_file_mtime,include_file_ctime
    fi
    cmake -S . -B "$folder" "${extra[@]}" "$@" > /dev/null
}

# quietly LOG COMMAND...: shows the command's output only if it fails.
quietly() {
    local log=$1
    shift
    "$@" > "$log" 2>&1 || {
        cat "$log"
        return 1
    }
}

# build FOLDER
build() { quietly "$1/build.log" cmake --build "$1" --parallel "$jobs"; }

# Runs all tests but those labelled "long" and "paper" and, without --all, "thorough".
run_tests() {
    ctest --test-dir "$1" --label-exclude "long|paper$($all || echo '|thorough')" --parallel "$jobs" --output-on-failure "${@:2}"
}

# meanwhile COMMAND...: runs it beside what follows, so that no processor waits for the last of its parts. One at a time, in a
# process group of its own: without one its programs would ignore SIGINT.
# await: waits for its end, and fails if it has failed.
beside=
meanwhile() {
    await
    set -m
    "$@" &
    set +m
    beside=$!
}
await() {
    local process=$beside
    beside=
    [[ -z $process ]] || wait "$process"
}
trap '[[ -z $beside ]] || kill -- "-$beside" 2> /dev/null || true' EXIT

# Shows the end of ctest's output, which lists skipped tests too.
test_variant() {
    quietly "build/$1/tests.log" run_tests "build/$1"
    printf '\n== tests: %s\n%s\n' "$2" "$(sed -n '/tests passed/,$p' "build/$1/tests.log")"
}

# variant NAME WHAT OPTION...: builds build/NAME.
variant() {
    stage "$2"
    configure "build/$1" "${@:3}"
    build "build/$1"
}

# A Debug build by Clang, so that assertions check the invariants. Light optimisation and few, large units keep it short.
readonly sanitized=(-DCMAKE_CXX_COMPILER=clang++ -DCMAKE_BUILD_TYPE=Debug -DCMAKE_CXX_FLAGS_DEBUG="-O1 -g1" -DLAMELLA_LARGE_UNITS=ON
    -DLAMELLA_BUILD_BENCH=OFF)

# build_release THOROUGH BENCH: each ON or OFF. A new build that only tests need takes a minute less in large units.
build_release() {
    local units=()
    [[ -e build/CMakeCache.txt ]] || units=(-DLAMELLA_LARGE_UNITS=ON)
    configure build -DCMAKE_BUILD_TYPE=Release -DLAMELLA_WERROR=ON -DLAMELLA_BUILD_BENCH="$2" \
        -DLAMELLA_THOROUGH_TESTS="$1" -DLAMELLA_BUILD_PYTHON="$1" "${units[@]}"
    build build
}

# Runs the ctest tests of that name, or else the cases of lamella_tests whose names contain the word, or else what only the
# thorough build has.
run_named() {
    local word
    run_ctest() { ctest --test-dir build --parallel "$jobs" --output-on-failure --no-tests=error --tests-regex "$1" "${@:2}"; }
    for word in "$@"; do
        if [[ $(run_ctest "$word" --show-only) != *"Total Tests: 0"* ]]; then
            run_ctest "$word"
        # Its status is the number of names.
        elif [[ -n $(build/tests/lamella_tests --list-test-names-only "*$word*" || true) ]]; then
            build/tests/lamella_tests --warn NoTests "*$word*"
        else
            stage "thorough tests"
            build_release ON OFF
            run_ctest "$word"
        fi
    done
}

check_format() {
    stage "format"
    find engine include tests bench tools -name '*.[ch]pp' -print0 | xargs -0 clang-format --dry-run -Werror
}

# The documentation; the binary form of the C interface: programs that were compiled with an older header must still run; the
# golden slices under Windows, on ARM and in WebAssembly, which must be the bytes of Linux; and the page in a browser.
check_interfaces_and_platforms() {
    local page
    quietly build/page.log tools/view/test.sh build/tools/lamella build/view &
    page=$!
    quietly build/docs.log tools/docs.sh
    quietly build/abi.log tests/abi/check.sh build/engine/liblamella_c.so
    quietly build/abi.log tests/abi/check.sh build/engine/liblamella_c.so --self-test
    quietly build/platforms.log tools/platforms.sh --golden
    printf '\n== golden slices of other systems: assertions\n%s\n' "$(tail -n 3 build/platforms.log)"
    wait "$page"
    printf '\n== the page in a browser: %s\n' "$(tail -n 1 build/page.log)"
}

# Checks every source of the engine, the tools and the oracle, with the headers that they include. Skips the other tests
# and bench/.
check_style() {
    stage "clang-tidy"
    # The static analyser takes as long as all other checks. TIDY_CHECKS= (empty) runs it too.
    run-clang-tidy -quiet -j "$jobs" -checks="${TIDY_CHECKS--clang-analyzer-*}" -p build/asan \
        "^$PWD/(build/asan/)?(engine|tools|tests/CMakeFiles/lamella_test_support[.]dir)/" > build/tidy.log 2>&1 || {
        grep -A 5 -E '(error|warning):' build/tidy.log || cat build/tidy.log
        exit 1
    }
}

check_memory() {
    local -r what="address and undefined-behaviour sanitizers"
    variant asan "$what" "${sanitized[@]}" -DLAMELLA_SANITIZE=address -DLAMELLA_WERROR=ON -DCMAKE_EXPORT_COMPILE_COMMANDS=ON
    check_style
    UBSAN_OPTIONS=print_stacktrace=1 meanwhile test_variant asan "$what"
}

# Uses std::thread, because the sanitizer cannot see into Debian's oneTBB.
check_threads() {
    variant tsan "thread sanitizer" "${sanitized[@]}" -DLAMELLA_SANITIZE=thread -DLAMELLA_PARALLEL=std -DLAMELLA_BUILD_TOOLS=OFF \
        -DLAMELLA_BUILD_MEDICAL=OFF
    TSAN_OPTIONS=halt_on_error=1 meanwhile test_variant tsan "thread sanitizer"
}

all=false
stage "packages"
install_missing "${build_packages[@]}"
if [[ "${1:-}" == --core ]]; then
    # Of a Debug build, so that assertions check the invariants.
    variant core "the engine alone" -DCMAKE_BUILD_TYPE=Debug -DCMAKE_CXX_FLAGS_DEBUG=-O1 -DLAMELLA_LARGE_UNITS=ON \
        -DLAMELLA_BUILD_{IO,SHARED,TOOLS,TESTS,BENCH}=OFF -DLAMELLA_BUILD_CORE_TESTS=ON -DLAMELLA_CORE_TESTS=engine/
    test_variant core "the engine alone"
    exit
fi
if [[ "${1:-}" == --platforms ]]; then
    install_missing "${golden_packages[@]}" "${platform_packages[@]}"
    tools/platforms.sh "${@:2}"
    exit
fi
install_missing "${test_packages[@]}" "${python_packages[@]}"
if [[ "${1:-}" == --all ]]; then
    all=true
    shift
    install_missing "${check_packages[@]}" "${picture_packages[@]}" "${bench_packages[@]}" "${reader_packages[@]}" "${golden_packages[@]}" \
        "${page_packages[@]}" "${page_test_packages[@]}"
    check_format
fi

stage "release build"
if $all; then
    build_release ON ON
    meanwhile check_interfaces_and_platforms
    check_memory
    check_threads
    await
else
    build_release OFF OFF
fi

stage "tests of the release build"
if (($# > 0)); then
    run_named "$@"
else
    run_tests build
fi
