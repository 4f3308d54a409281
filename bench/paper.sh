#!/usr/bin/env bash
# Runs the paper's experiments on this machine: makes the models, runs every algorithm that the paper names, and writes
# tables and figures to bench/results/paper.md. Finished rows are kept in build/paper and not measured again.
#
#     bench/paper.sh                 everything; takes an hour or two
#     bench/paper.sh --quick         liver, femur and bunny
#     bench/paper.sh --help          options for models, threads and time limit
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source tools/packages.sh

install_missing "${build_packages[@]}" "${bench_packages[@]}" libcgal-dev
generator=()
[[ -e build/CMakeCache.txt ]] || generator=(-G Ninja)
cmake -S . -B build "${generator[@]}" -DCMAKE_BUILD_TYPE=Release -DLAMELLA_BUILD_BENCH=ON -DLAMELLA_LARGE_UNITS=OFF > /dev/null
cmake --build build --parallel "$(nproc)" --target lamella_paper_row lamella_cli lamella_peers | tail -n 1
exec bench/scripts/paper.py --build build "$@"
