#!/usr/bin/env bash
# fuzz.sh SECONDS: builds the fuzzers with Clang and runs them for SECONDS in total. Each starts from the inputs of
# earlier runs and the corpus in tests/fuzz. Fails on the first finding and keeps its input in build/fuzz/findings.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

[[ "${1:-}" =~ ^[1-9][0-9]*$ ]] || {
    echo "usage: tools/fuzz.sh SECONDS" >&2
    exit 2
}
readonly targets=(read slice assemble check region combine)
readonly seconds=$((($1 + ${#targets[@]} - 1) / ${#targets[@]}))
readonly folder=build/fuzz

generator=()
[[ -e "$folder/CMakeCache.txt" ]] || generator=(-G Ninja)
cmake -S . -B "$folder" "${generator[@]}" -DCMAKE_BUILD_TYPE=Debug -DCMAKE_CXX_FLAGS=-O1 -DCMAKE_CXX_COMPILER=clang++ \
    -DLAMELLA_BUILD_FUZZERS=ON -DLAMELLA_BUILD_BENCH=OFF > /dev/null
cmake --build "$folder" --parallel "$(nproc)" --target "${targets[@]/#/fuzz_}" > "$folder/build.log" || {
    cat "$folder/build.log"
    exit 1
}

mkdir -p "$folder/findings"
for target in "${targets[@]}"; do
    grown=$folder/corpus/$target
    log=$folder/$target.log
    mkdir -p "$grown"
    UBSAN_OPTIONS=print_stacktrace=1 "$folder/tests/fuzz/fuzz_$target" -max_total_time="$seconds" -timeout=20 \
        -rss_limit_mb=2048 -max_len=4096 -artifact_prefix="$folder/findings/$target-" -print_final_stats=1 \
        "$grown" "tests/fuzz/corpus/$target" > "$log" 2>&1 || {
        tail -n 60 "$log"
        echo "fuzz_$target: a finding; its input is in $folder/findings"
        exit 1
    }
    echo "fuzz_$target: $(sed -n 's/^stat::number_of_executed_units: *//p' "$log") executions in $seconds s, no finding"
done
