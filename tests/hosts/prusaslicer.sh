#!/usr/bin/env bash
# Puts lamella into PrusaSlicer in the place of its own slicing: its tests must pass as they do without, its layers must be
# the same, and both are timed. So are operations on layers by the host and by lamella. By hand: it installs packages, fetches
# 28 MB and compiles for about half an hour.
#
#     tests/hosts/prusaslicer.sh [WORK]
#
# WORK holds sources, builds and logs; what is there is not made again (default build/hosts/prusaslicer). The tables go to
# bench/results/hosts.md.
set -euo pipefail
root="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
source "$root/tools/packages.sh"

work="${1:-$root/build/hosts/prusaslicer}"
work="$(mkdir -p "$work" && cd "$work" && pwd)"
models="$root/../shared/models"
adapter="$root/tests/hosts/prusaslicer"
prefix="$work/lamella/prefix"
for name in liver femur brain; do
    [[ -e "$models/$name.stl" ]] || stop "$models/$name.stl is missing"
done
mkdir -p "$work/logs"

host_packages=(
    dpkg-dev cmake ninja-build g++ catch2 gettext
    libboost-{atomic,chrono,date-time,filesystem,iostreams,locale,log,nowide,regex,thread}-dev
    libcereal-dev libcgal-dev libcurl4-openssl-dev libdbus-1-dev libeigen3-dev libexpat1-dev libgl-dev libglew-dev
    libglu1-mesa-dev libjpeg-dev libnlopt-cxx-dev libopenvdb-dev libpng-dev libqhull-dev libtbb-dev
)
suites=(fff_print sla_print libslic3r)

step() { printf '\n== %s (%d s so far)\n' "$1" "$SECONDS"; }

# logged NAME COMMAND...: the output goes to a log, of which a failure shows the end.
logged() {
    local log="$work/logs/$1.txt"
    shift
    "$@" > "$log" 2>&1 || { tail -n 20 "$log" >&2; stop "$* failed; all of its output: $log"; }
}

# Debian's source package by an apt configuration of its own: the machine's stays as it is.
fetch() {
    [[ ! -e "$work/source/CMakeLists.txt" ]] || return 0
    mkdir -p "$work/apt/lists/partial" "$work/apt/cache/archives/partial"
    echo "deb-src [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] http://deb.debian.org/debian bookworm main" \
        > "$work/apt/sources.list"
    cat > "$work/apt/apt.conf" << END
Dir::Etc::sourcelist "$work/apt/sources.list";
Dir::Etc::sourceparts "-";
Dir::State::lists "$work/apt/lists";
Dir::Cache "$work/apt/cache";
APT::Sandbox::User "root";
END
    (
        cd "$work"
        export APT_CONFIG="$work/apt/apt.conf"
        logged apt_update apt-get update
        logged apt_source apt-get source --download-only prusa-slicer
        rm -rf unpacked
        logged unpack dpkg-source -x slic3r-prusa_*.dsc unpacked
        mv unpacked source
    )
}

build_lamella() {
    logged lamella_configure cmake -S "$root" -B "$work/lamella/build" -G Ninja -DCMAKE_BUILD_TYPE=Release "${launcher[@]}" \
        -DLAMELLA_BUILD_TESTS=OFF -DLAMELLA_BUILD_BENCH=OFF -DLAMELLA_BUILD_TOOLS=OFF -DLAMELLA_BUILD_IO=OFF
    logged lamella_build nice -n 5 cmake --build "$work/lamella/build" --parallel "$(nproc)"
    logged lamella_install cmake --install "$work/lamella/build" --prefix "$prefix"
}

# build_host TARGETS OPTION...
build_host() {
    local targets="$1"
    shift
    logged host_configure cmake -S "$work/source" -B "$work/build" -G Ninja -DCMAKE_BUILD_TYPE=Release "${launcher[@]}" \
        -DSLIC3R_GUI=OFF -DSLIC3R_FHS=ON -DSLIC3R_ENABLE_FORMAT_STEP=OFF -DSLIC3R_BUILD_TESTS=ON \
        "-DCMAKE_C_FLAGS=-g0 -w" "-DCMAKE_CXX_FLAGS=-g0 -w" "-DCMAKE_CXX_FLAGS_RELEASE=-O1 -DNDEBUG" \
        "-DOPENVDB_FIND_MODULE_PATH=/usr/lib/$(dpkg-architecture -qDEB_HOST_MULTIARCH)/cmake/OpenVDB" \
        "-DCMAKE_PROJECT_PrusaSlicer_INCLUDE=$adapter/inject.cmake" "-DCMAKE_PREFIX_PATH=$prefix" "$@"
    # shellcheck disable=SC2086
    logged host_build nice -n 5 ninja -C "$work/build" $targets
}

# keep LABEL: the test programs of this build, before the next one replaces them.
keep() {
    local suite
    mkdir -p "$work/$1"
    for suite in "${suites[@]}"; do
        cp "$work/build/tests/$suite/${suite}_tests" "$work/$1/"
    done
}

# run_suites LABEL: results go to LABEL/SUITE.xml; tables.py judges their failures. The suites write meshes and pictures to
# where they are run.
run_suites() {
    local suite
    mkdir -p "$work/$1/output"
    for suite in "${suites[@]}"; do
        (cd "$work/$1/output" && "../${suite}_tests" --reporter xml --out "../$suite.xml") > "$work/logs/$1_$suite.txt" 2>&1 || true
        [[ -s "$work/$1/$suite.xml" ]] || stop "${suite}_tests wrote no results: $work/logs/$1_$suite.txt"
    done
}

# compare TASK: without what the host logs on standard output as it starts.
compare() {
    "$work/build/lamella_compare" "$1" "$work/source/tests/data" "$models" | grep --line-buffered -v '\[trace\]'
}

test_targets="libslic3r ${suites[*]/%/_tests}"
launcher=()
if command -v ccache > /dev/null; then
    launcher=(-DCMAKE_C_COMPILER_LAUNCHER=ccache -DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
    export CCACHE_SLOPPINESS=pch_defines,time_macros,include_file_mtime,include_file_ctime
fi

step "packages and sources"
install_missing "${host_packages[@]}"
fetch

if [[ ! -e "$work/own/libslic3r.xml" ]]; then
    step "PrusaSlicer by itself: build"
    build_host "$test_targets" -DLAMELLA_ADAPTER=OFF
    keep own
    step "PrusaSlicer by itself: tests"
    run_suites own
fi

step "lamella, and PrusaSlicer with the adapter: build"
build_lamella
build_host "$test_targets lamella_compare" -DLAMELLA_ADAPTER=ON
keep adapter
table="$work/tables"
mkdir -p "$table"
status=0

step "PrusaSlicer with the adapter: tests"
run_suites adapter
python3 "$adapter/tables.py" suites "$work/own" "$work/adapter" "${suites[@]}" | tee "$table/suites.md" || status=1
step "layers of both"
compare agree | tee "$table/layers.md" || status=1
step "times of both"
compare time | tee "$table/times.md" || status=1
step "operations on layers by both"
compare operations | tee "$table/operations.md" || status=1
python3 "$adapter/tables.py" page "$table" "$work/build" tests/hosts/prusaslicer.sh > "$work/hosts.md"
mv "$work/hosts.md" "$root/bench/results/hosts.md"
((status == 0)) || stop "tests that PrusaSlicer passes by itself fail, layers differ or bars are missed: see above"
