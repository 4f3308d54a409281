#!/usr/bin/env bash
# Mutation: does the suite catch bugs that were put in on purpose? run.sh [-d FOLDER] [PATCH...] applies each patch (all of
# them by default) to a copy of the sources, builds, and runs the tests until one fails. Fails if a mutant survives or a
# patch no longer applies. With -d the copy and its build are kept in FOLDER for the next run.
#
# A patch begins with what the bug is in one line, then
#     Tests: TAGS    which tests to run before all others; `cli` for those of the command line tool
#     Needs: FLAG    the processor's flag without which the changed code does not run
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
root=$(cd "$here/../.." && pwd)
readonly here root
readonly test_seconds=600 test_kilobytes=$((16 << 20))  # a mutant may loop, or allocate, for ever

scratch=
if [[ "${1:-}" == -d ]]; then
    mkdir -p "$2"
    scratch=$(cd "$2" && pwd)
    shift 2
else
    scratch=$(mktemp -d)
    trap 'rm -rf "$scratch"' EXIT
fi
readonly scratch sources=$scratch/src build=$scratch/build log=$scratch/log
mkdir -p "$sources"

# Only what differs is written, so that only that is built again.
copy_sources() {
    local file
    while IFS= read -r -d '' file; do
        cmp -s "$root/$file" "$sources/$file" || install -D -m 644 "$root/$file" "$sources/$file"
    done < <(cd "$root" && find CMakeLists.txt engine include tests tools bench/baselines -type f -print0)
    while IFS= read -r -d '' file; do
        [[ -e "$root/$file" ]] || rm "$sources/$file"
    done < <(cd "$sources" && find . -type f -print0)
}

# The copy may lie within a repository, whose files git would look for.
patch_sources() { GIT_CEILING_DIRECTORIES=$scratch git -C "$sources" apply "$@"; }

build_suite() { cmake --build "$build" --target lamella_tests lamella_cli > "$log" 2>&1; }

# limited COMMAND...
limited() { (ulimit -v "$test_kilobytes" -c 0 && exec timeout -k 10 "$test_seconds" "$@") > "$log" 2>&1; }

unit_tests() { limited "$build/tests/lamella_tests" --abort "$@"; }

cli_tests() { limited ctest --test-dir "$build" --tests-regex '^cli_' --stop-on-failure; }

# run_tests TAGS: those likeliest to fail first.
run_tests() {
    if [[ "$1" == cli ]]; then
        cli_tests && unit_tests
    else
        unit_tests "$1" && unit_tests '~[scale]' && unit_tests '[scale]' && cli_tests
    fi
}

# failed_test STATUS: the test that failed, from $log: Catch2 writes its name beneath a line, ctest behind a number.
failed_test() {
    local status=$1 name
    name=$(awk 'ruled { print; exit } { ruled = /^-+$/ && length($0) > 70 }' "$log")
    [[ -n "$name" ]] || name=$(sed -n 's/^[[:space:]]*[0-9]* - \(cli_[a-z_]*\).*/\1/p' "$log" | head -n 1)
    echo "${name:-exit status $status}"
}

# field NAME PATCH
field() { sed -n "s/^$1: //p" "$2"; }

# Prints what became of the mutant.
try() {
    local patch=$1 needs outcome
    needs=$(field Needs "$patch")
    if [[ -n "$needs" ]] && ! grep -qw "$needs" /proc/cpuinfo; then
        echo "skipped   (needs $needs)"
        return
    fi
    patch_sources "$patch" 2> "$log" || {
        echo "NO PATCH  $(head -n 1 "$log")"
        return
    }
    if ! build_suite; then
        outcome="NO BUILD  $(grep -m 1 error "$log")"
    elif run_tests "$(field Tests "$patch")"; then
        outcome="SURVIVED"
    else
        outcome="caught    $(failed_test $?)"
    fi
    patch_sources -R "$patch"
    echo "$outcome"
}

patches=("$@")
[[ $# -gt 0 ]] || patches=("$here"/*.patch)

copy_sources
generator=()
[[ -e "$build/CMakeCache.txt" ]] || generator=(-G Ninja)
cmake -S "$sources" -B "$build" "${generator[@]}" -DCMAKE_BUILD_TYPE=Release -DLAMELLA_BUILD_BENCH=OFF \
    -DLAMELLA_SHARED_MODELS= > "$log"
build_suite && run_tests '[solids]' || {
    cat "$log"
    echo "the suite fails without any mutant" >&2
    exit 1
}
echo "the suite passes, after $SECONDS s"

failures=0
for patch in "${patches[@]}"; do
    outcome=$(try "$patch")
    printf '%-28s %s\n' "$(basename "$patch" .patch)" "$outcome"
    [[ "$outcome" == caught* || "$outcome" == skipped* ]] || failures=$((failures + 1))
done
echo "${#patches[@]} mutants, $failures not caught, $SECONDS s"
((failures == 0))
