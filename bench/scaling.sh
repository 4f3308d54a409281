#!/usr/bin/env bash
# Measures how slices scale over the cores of this machine, and writes one page to send: bench/results/scaling_HOST.md
#
#     bench/scaling.sh            everything; takes half an hour on 64 cores
#     bench/scaling.sh --quick    a hundredth of the sizes, into build/bench-quick: shows only that it runs
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

where=(build/scaling bench/results --cache build/bench-models)
[[ "${1:-}" != --quick ]] || where=(build/bench-quick build/bench-quick --cache build/bench-models/quick)
# What is not pinned first. Bars that are not met stand on the page.
RESULTS=${where[0]} FILTER='^(partition|cores)' bench/run.sh "$@" || (($? == 1))
exec bench/scripts/scaling.py "${where[@]}" --shared ../shared/models "$@"
