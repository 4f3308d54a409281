# Sourced by the tests of this folder, which are called with the tool and a folder to work in:
#
#     NAME.sh TOOL FOLDER
#
# Makes meshes and what one machine makes of them, and stops what was started, by its process ids.
set -euo pipefail
root="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
source "$root/tools/packages.sh"
install_missing "${cluster_packages[@]}"

(($# == 2)) || stop "usage: $0 TOOL FOLDER"
tool="$(realpath "$1")"
rm -rf "$2"
work="$(mkdir -p "$2" && cd "$2" && pwd)"
cd "$work"
# Scripts call the program by its name.
mkdir bin
ln -s "$tool" bin/lamella
export PATH="$work/bin:$PATH"

step() { printf '\n== %s (%d s so far)\n' "$1" "$SECONDS"; }

# fail MESSAGE: what the engines said is in the work folder.
fail() {
    echo "FAILED: $1 (see $work)" >&2
    exit 1
}

# wait_for SECONDS WHAT COMMAND...: until the command succeeds.
wait_for() {
    local until=$((SECONDS + $1)) what="$2"
    shift 2
    until "$@" > /dev/null 2>&1; do
        ((SECONDS < until)) || fail "waited in vain for $what"
        sleep 0.1
    done
}

# start NAME COMMAND...: runs it until the test ends; its output goes to log/NAME. The last one started is stopped first.
started=()
start() {
    local name="$1"
    shift
    mkdir -p log
    "$@" > "log/$name" 2>&1 &
    started=($! "${started[@]}")
}

stop_started() {
    local pid
    for pid in "${started[@]}"; do
        kill -TERM "$pid" 2> /dev/null || true
        wait "$pid" 2> /dev/null || true
    done
    started=()
}
trap stop_started EXIT

# What is asked of every engine.
batch_options=(--output='masks/{stem}.nii.gz' --output='masks/{stem}.csv' --spacing=0.5,0.5,0.1 --frame=lps)

# same FOLDER FOLDER: every file of both.
same() {
    diff -r "$1" "$2" || fail "$1 and $2 differ"
    echo "$(find "$1" -type f | wc -l) files, all the same"
}

# files_in FOLDER COUNT: whether so many masks are there.
files_in() { (($(find "$1" -name '*.nii.gz' 2> /dev/null | wc -l) >= $2)); }

# Twelve meshes, of which the larger take a second, and a file that is none.
step "one machine"
shapes=(sphere torus gyroid bone)
mkdir meshes
for i in {0..11}; do
    lamella make "${shapes[i % 4]}" --triangles $((20000 + i * 50000)) -o "meshes/m$i.stl" > /dev/null
done
head -c 1000 meshes/m0.stl > meshes/damaged.stl
status=0
lamella batch meshes "${batch_options[@]}" > one_machine.txt || status=$?
((status == 5)) || fail "one machine: status $status, not 5 for the damaged mesh"
mv masks one_machine  # Its files name each other: all engines write a folder called masks.
