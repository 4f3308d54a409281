"""The client of dask.sh, and what kills a worker.

    dask_many.py SCHEDULER_FILE PID...

The workers are named 0, 1, ... in the order of their process ids.
"""

import json
import os
import pathlib
import signal
import subprocess
import sys
import time

import distributed

import lamella.dask

# Of the 1e9 that a worker has: one mesh at a time, though the worker has two threads.
NEED = 600_000_000


def begin(client):
    paths = sorted(map(str, pathlib.Path("meshes").iterdir()))
    outputs = ["masks/{stem}.nii.gz", "masks/{stem}.csv"]
    return lamella.dask.slice_many(client, paths, outputs, memory=NEED, spacing=(0.5, 0.5, 0.1), frame="lps")


def children_of(pid):
    """Numbers of processes."""
    return [int(word) for word in subprocess.run(["pgrep", "-P", str(pid)], stdout=subprocess.PIPE, check=False).stdout.split()]


def kill_one_that_slices(client, pids, many):
    """After the first meshes are done. Returns its name, and the process id of the batch that it ran."""
    while True:
        assert not all(future.done() for future in many.futures), "all was over before a worker could be killed"
        keys = {worker: keys for worker, keys in client.processing().items() if keys}
        names = {address: info["name"] for address, info in client.scheduler_info()["workers"].items()}
        for address in keys:
            name = int(names[address])
            if any(future.done() for future in many.futures) and children_of(pids[name]):
                child = children_of(pids[name])[0]
                os.kill(pids[name], signal.SIGKILL)
                return name, child
        time.sleep(0.02)


def most_at_once(client, pids, many):
    """Tools of one worker at the same time, as long as any is at work."""
    most = 0
    while not all(future.done() for future in many.futures):
        most = max([most] + [len(children_of(pid)) for pid in pids])
        time.sleep(0.02)
    return most


def main(scheduler_file, *pids):
    pids = [int(pid) for pid in pids]
    client = distributed.Client(scheduler_file=scheduler_file)
    client.wait_for_workers(len(pids))
    many = begin(client)
    name, child = kill_one_that_slices(client, pids, many)
    most = most_at_once(client, pids, many)
    rows = many.rows()
    assert most == 1, f"{most} meshes at once on a worker that has memory for one"
    assert len(client.scheduler_info()["workers"]) == len(pids) - 1
    assert not pathlib.Path(f"/proc/{child}").exists(), "the tool outlived its worker"
    failed = {row["mesh"]: row["reason"] for row in rows if row["status"] != "done"}
    assert list(failed) == ["meshes/damaged.stl"], failed
    assert rows == [json.loads(line) for line in open("one_machine/results.jsonl")]
    print(f"{len(rows)} meshes; worker {name} was killed while it sliced; failed: {failed}")


if __name__ == "__main__":
    main(*sys.argv[1:])
