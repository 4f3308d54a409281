#!/usr/bin/env bash
# The paper's experiments on this machine: makes its models, runs every algorithm that it names, and writes its tables and
# figures to bench/results/paper.md. Rows that are finished are kept in build/paper and not run again.
#
#     bench/paper.sh                 everything; takes an hour or two
#     bench/paper.sh --quick         liver, femur and bunny
#     bench/paper.sh --help          which models, threads and limit may be asked for
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source tools/packages.sh

install_missing "${build_packages[@]}" libcgal-dev python3
generator=()
[[ -e build/CMakeCache.txt ]] || generator=(-G Ninja)
cmake -S . -B build "${generator[@]}" -DCMAKE_BUILD_TYPE=Release -DLAMELLA_BUILD_BENCH=ON > /dev/null
cmake --build build --parallel --target lamella_paper_row lamella_lower_bound lamella_cli lamella_peers | tail -n 1
exec python3 bench/scripts/paper.py --build build "$@"
