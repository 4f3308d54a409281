#!/usr/bin/env bash
# Builds, runs every benchmark, and makes the tables of bench/README.md and a plot of scaling. Prints the table of bars
# last.
#
#     bench/run.sh            everything; takes tens of minutes, the first time some more for the meshes
#     bench/run.sh --quick    a hundredth of the sizes, into build/bench-quick: shows only that the benchmarks run
#
# The raw output goes to build/bench-runs: Google Benchmark's JSON, with every measurement, and the like. The medians go to
# bench/results/summary.json, from which the tables are made.
#
# PIN=LIST pins the whole process to these cores (taskset -c LIST). FILTER=REGEX runs only the benchmarks that match,
# FILTER=-REGEX only those that do not. The medians of all others stay, if they were measured on the same machine.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source tools/packages.sh

quick=()
results=bench/results
runs=build/bench-runs
if [[ "${1:-}" == --quick ]]; then
    quick=(--quick)
    results=build/bench-quick
    runs=build/bench-quick
elif (($# > 0)); then
    echo "usage: bench/run.sh [--quick]" >&2
    exit 2
fi

stage() { printf '\n== %s (%d s so far)\n' "$1" "$SECONDS"; }

stage "packages and build"
install_missing "${build_packages[@]}" "${bench_packages[@]}" python3-numpy
generator=()
[[ -e build/CMakeCache.txt ]] || generator=(-G Ninja)
cmake -S . -B build "${generator[@]}" -DCMAKE_BUILD_TYPE=Release -DLAMELLA_BUILD_BENCH=ON -DLAMELLA_LARGE_UNITS=OFF > /dev/null
cmake --build build --parallel --target lamella_bench lamella_partition lamella_peak lamella_cli | tail -n 1

# Delete cached meshes that an older version of the generator made.
cache=build/bench-models
if [[ -d "$cache" && -n "$(find tools/models -newer "$cache/made" 2> /dev/null || echo unknown)" ]]; then
    rm -rf "$cache"
fi
mkdir -p "$cache" "$results" "$runs"
[[ -e "$cache/made" ]] || touch "$cache/made"

where=("--cache=$cache")
[[ -d ../shared/models ]] && where+=(--shared=../shared/models)
pin=()
[[ -z "${PIN:-}" ]] || pin=(taskset -c "$PIN")

stage "files of every format"
triangles=$((${#quick[@]} > 0 ? 10000 : 1000000))
formats=$cache/read-$triangles
if [[ ! -e "$formats/3mf.3mf" ]]; then
    mkdir -p "$formats"
    build/tools/lamella make bone --triangles "$triangles" -o "$formats/mesh.stl" > /dev/null
    /usr/bin/python3 bench/python/mesh_formats.py "$formats/mesh.stl" "$formats"
fi

stage "benchmarks"
"${pin[@]}" build/bench/lamella_bench "${quick[@]}" "${where[@]}" \
    --benchmark_filter="${FILTER:-.}" --benchmark_out="$runs/bench.json" --benchmark_out_format=json --benchmark_display_aggregates_only=true

stage "bands and parts by themselves"
"${pin[@]}" build/bench/lamella_partition "${quick[@]}" "${where[@]}" > "$runs/partition.json"

stage "peak memory"
meshes=()
[[ -e ../shared/models/liver.stl ]] && meshes+=(liver=../shared/models/liver.stl)
if ((${#quick[@]} == 0)); then
    meshes+=("scan=$(echo "$cache"/bone-3400000-*um.stl)" "figure=$(echo "$cache"/bone-8800000-*um.stl)"
        "skull=$(echo "$cache"/bone-16700000-*um.stl)")
else
    meshes+=("scan=$(echo "$cache"/bone-34000-*mm.stl)")
fi
for mesh in "${meshes[@]}"; do
    for band_planes in 0 16 1; do
        build/bench/lamella_peak "${mesh%%=*}" "${mesh#*=}" 0.032 2 "$band_planes"
    done
done > "$runs/peaks.json"

stage "tables and plot"
add=()
[[ -z "${FILTER:-}" ]] || add=(--add)
"${pin[@]}" python3 bench/scripts/summarise.py "$runs" "$results" "${add[@]}"
readme=()
((${#quick[@]} > 0)) || readme=(bench/README.md)
python3 bench/scripts/figures.py "$results" "${readme[@]}"
status=0
python3 bench/scripts/bars.py "$results" || status=$?
if ((status == 1 && ${#quick[@]} > 0)); then
    status=0 # bars hold for full sizes only
fi
exit "$status"
