#!/usr/bin/env bash
# A Dask scheduler with four worker processes, one of which is killed while it slices: files and table are those of one machine.
# PYTHONPATH holds the package.
source "$(dirname "${BASH_SOURCE[0]}")/support.sh"
[[ -d "$PYTHONPATH/lamella" ]] || { echo "skipped: this build has no Python package (-DLAMELLA_BUILD_PYTHON=ON)"; exit 77; }

step "four workers"
start scheduler dask scheduler --host 127.0.0.1 --port 0 --no-dashboard --scheduler-file scheduler.json
workers=()
for i in 0 1 2 3; do
    start "worker_$i" dask worker --scheduler-file scheduler.json --host 127.0.0.1 --name "$i" --nthreads 2 --no-nanny --no-dashboard \
        --memory-limit 0 --resources MEMORY=1e9
    workers+=("${started[0]}")
done
/usr/bin/python3 "$root/tests/cluster/dask_many.py" scheduler.json "${workers[@]}"
same one_machine masks
