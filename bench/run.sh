#!/usr/bin/env bash
# Builds, runs every benchmark, and makes the tables of bench/README.md and a plot of scaling, and prints them.
#
#     bench/run.sh            everything; takes tens of minutes, the first time some more for the meshes
#     bench/run.sh --quick    a hundredth of the sizes, into build/bench-quick: shows only that the benchmarks run
#
# The raw output goes to build/bench-runs: Google Benchmark's JSON, with every measurement, and the like. The medians go to
# bench/results/summary.json, from which the tables are made.
#
# PIN=LIST pins the whole process to these cores (taskset -c LIST). FILTER=REGEX runs only the benchmarks that match,
# FILTER=-REGEX only those that do not. The medians of all others stay, if they were measured on the same machine.
# RESULTS=FOLDER puts medians and plot there, and leaves bench/README.md as it is.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source tools/packages.sh

size=full
results=${RESULTS:-bench/results}
runs=build/bench-runs
cache=build/bench-models
readme=(bench/README.md)
[[ -z "${RESULTS:-}" ]] || readme=()
triangles=1000000
rounds=5
if [[ "${1:-}" == --quick ]]; then
    size=quick
    results=build/bench-quick
    runs=build/bench-quick
    cache=build/bench-models/quick
    readme=()
    triangles=10000
    rounds=1
elif (($# > 0)); then
    stop "usage: bench/run.sh [--quick]"
fi

# wanted NAME: true if FILTER asks for that benchmark.
wanted() {
    if [[ "${FILTER:-}" == -* ]]; then [[ ! "$1" =~ ${FILTER#-} ]]; else [[ "$1" =~ ${FILTER:-.} ]]; fi
}

stage() { printf '\n== %s (%d s so far)\n' "$1" "$SECONDS"; }

stage "packages and build"
install_missing "${build_packages[@]}" "${bench_packages[@]}"
generator=()
[[ -e build/CMakeCache.txt ]] || generator=(-G Ninja)
cmake -S . -B build "${generator[@]}" -DCMAKE_BUILD_TYPE=Release -DLAMELLA_BUILD_BENCH=ON -DLAMELLA_LARGE_UNITS=OFF > /dev/null
cmake --build build --parallel "$(nproc)" --target lamella_bench lamella_peak lamella_first lamella_paper_row lamella_cli | tail -n 1

# Delete cached meshes that an older generator or catalogue made.
if [[ -n "$(find tools/models bench/programs/catalogue.cpp -newer "$cache/made" 2> /dev/null || echo unknown)" ]]; then
    rm -rf "$cache"
fi
mkdir -p "$cache/read" "$results" "$runs"
[[ -e "$cache/made" ]] || touch "$cache/made"

pin=()
[[ -z "${PIN:-}" ]] || pin=(taskset -c "$PIN")

stage "files of every format"
if [[ ! -e "$cache/read/3mf.3mf" ]]; then
    build/tools/lamella make bone --triangles "$triangles" -o "$cache/read/mesh.stl" > /dev/null
    /usr/bin/python3 bench/python/mesh_formats.py "$cache/read/mesh.stl" "$cache/read"
fi

stage "benchmarks"
"${pin[@]}" build/bench/lamella_bench "$@" --cache "$cache" --shared ../shared/models --benchmark_filter="${FILTER:-.}" \
    --benchmark_out="$runs/bench.json" --benchmark_display_aggregates_only=true

stage "peak memory and first slices"
for mesh in ../shared/models/{liver,femur,brain}.stl "$cache"/{scan,figure,skull}.stl; do
    name=$(basename "$mesh" .stl)
    [[ -e "$mesh" ]] || continue
    for band_planes in 0 16 1; do
        ! wanted "peak/$name/bands_$band_planes/threads:2" ||
            build/bench/lamella_peak "peak/$name/bands_$band_planes/threads:2" "$mesh" 0.032 2 "$band_planes" contours
    done
    [[ $name == figure || $name == skull ]] || ! wanted "first/$name/slice/threads:2" || for _ in {1..15}; do
        "${pin[@]}" build/bench/lamella_first "first/$name/slice/threads:2" "$mesh" 0.032 2 0 contours
    done
done > "$runs/once.jsonl"

stage "crowded cores"
affinity=$("${pin[@]}" bash -c 'taskset -cp $$')
cores=$("${pin[@]}" nproc)
for mesh in ../shared/models/{liver,brain}.stl "$cache"/scan.stl; do
    name=$(basename "$mesh" .stl)
    [[ -e "$mesh" ]] && wanted "cores/$name/" || continue
    for ((round = 0; round < rounds; ++round)); do
        for times in 1 2 4 8; do
            "${pin[@]}" build/bench/lamella_first "cores/$name/times_$times/threads:$cores" "$mesh" 0.032 $((times * cores)) 0 contours
        done
        taskset -c "$(grep -oE '[0-9]+' <<< "${affinity#*:}" | head -n 1)" timeout 60 sh -c 'while :; do :; done' &
        "${pin[@]}" build/bench/lamella_first "cores/$name/neighbour/threads:$cores" "$mesh" 0.032 "$cores" 0 contours
        kill $! && wait $! 2> /dev/null || true
    done
done >> "$runs/once.jsonl"

stage "the authors' later way"
for mesh in ../shared/models/{liver,femur,brain,hip_femur}.stl "$cache"/{scan,scan_shuffled,figure,skull}.stl; do
    name=$(basename "$mesh" .stl)
    [[ -e "$mesh" ]] && wanted "baseline/$name/" || continue
    row=$(build/bench/lamella_paper_row topological "$mesh" 0.032 2 300)
    printf '{"name": "baseline/%s/topological/threads:1", %s\n' "$name" "${row#'{'}"
done >> "$runs/once.jsonl"

stage "tables and plot"
add=()
[[ -z "${FILTER:-}" ]] || add=(--add)
"${pin[@]}" /usr/bin/python3 bench/scripts/summary.py build "$runs" "$results" "$size" "${add[@]}"
status=0
/usr/bin/python3 bench/scripts/tables.py "$results" "${readme[@]}" || status=$?
[[ $size == full || $status != 1 ]] || status=0 # bars hold for full sizes only
exit "$status"
