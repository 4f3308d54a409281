#!/usr/bin/env python3
"""Disturbs batches at random moments, starts them again, and compares the tree with that of an undisturbed run.

    batch_kill.py LAMELLA          rounds by BATCH_KILLS (5), random numbers by BATCH_SEED (of the clock)

A round disturbs one batch up to three times: kill -9 of the batch or of one of its processes, SIGTERM, or writes that fail as on a
full disk. Then it runs to its end, and every byte must be as if nothing had happened.
"""

import collections
import os
import pathlib
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time

ROUNDS = int(os.environ.get("BATCH_KILLS", "5"))
SEED = int(os.environ.get("BATCH_SEED", str(time.time_ns() % 10**9)))
COMMAND = [sys.argv[1], "batch", "in", "large.jsonl", "-o", "out/{dir}/{stem}.csv", "--to", "csv,svg,jsonl", "--jobs", "2",
           "--retries", "1", "--progress", "never"]  # fmt: skip
OUT = pathlib.Path("out")


def start(command=COMMAND, **options):
    return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, **options)


def make_meshes():
    pathlib.Path("in/sub").mkdir(parents=True)
    for i in range(24):
        name = f"in/{'sub/' if i % 4 == 0 else ''}m{i}.stl"
        start([sys.argv[1], "make", ("sphere", "torus", "bone")[i % 3], "--triangles", str(500 * (i + 1)), "--height", "40", "-o", name]).wait()
    pathlib.Path("in/bad.stl").write_text("no mesh\n")
    with open("large.jsonl", "w") as rows:
        for i in range(3):
            start([sys.argv[1], "make", "bone", "--triangles", "200000", "--height", "60", "-o", f"large{i}.stl"]).wait()
            rows.write(f'{{"path":"large{i}.stl","spacing":[0.4,0.4,0.4],"frame":"lps","output":"out/masks/{{stem}}.nii.gz",'
                       '"to":"nii.gz,seg.nrrd,csv"}\n')  # fmt: skip


def tree():
    return {str(path): path.read_bytes() for path in OUT.rglob("*") if path.is_file()}


def kill_batch(batch, pause):
    pause()
    batch.kill()


def kill_while_writing(batch, pause):
    """When a file that is being written aside is seen."""
    pause()
    while batch.poll() is None and not any(OUT.rglob(".*.part")):
        pass
    batch.kill()


def terminate(batch, pause):
    pause()
    batch.terminate()


def kill_processes(batch, pause):
    for _ in range(random.randint(1, 4)):
        pause()
        try:
            running = pathlib.Path(f"/proc/{batch.pid}/task/{batch.pid}/children").read_text().split()
            os.kill(int(random.choice(running)), signal.SIGKILL)
        except (OSError, IndexError):  # none is running
            pass


def full_disk(batch, _):
    """No file may become larger than some that the batch writes."""
    largest = random.choice([1000, 10_000, 100_000])
    resource.prlimit(batch.pid, resource.RLIMIT_FSIZE, (largest, largest))


KINDS = [kill_while_writing, kill_batch, terminate, kill_processes, full_disk]


def main():
    random.seed(SEED)
    COMMAND[0] = sys.argv[1] = str(pathlib.Path(sys.argv[1]).resolve())
    folder = tempfile.mkdtemp(prefix="batch_kill.")
    os.chdir(folder)
    make_meshes()
    begun = time.monotonic()
    assert start().wait() == 5, "the undisturbed run has another exit status"
    seconds = time.monotonic() - begun
    whole = tree()
    seen = collections.Counter()
    for number in range(ROUNDS):
        shutil.rmtree(OUT)
        kinds = [KINDS[number % len(KINDS)], *random.choices(KINDS, k=random.randint(0, 2))]
        for disturb in kinds:
            batch = start()
            disturb(batch, lambda: time.sleep(random.uniform(0, seconds)))
            batch.wait()
        status, found = start().wait(), tree()
        different = [name for name in sorted({*found, *whole}) if found.get(name) != whole.get(name)]
        names = [kind.__name__ for kind in kinds]
        if status != 5 or different:
            sys.exit(f"FAILED: round {number}, seed {SEED}: {names}: exit status {status}, different: {different[:10]}; see {folder}")
        seen.update(names)
    shutil.rmtree(folder)
    print(f"{ROUNDS} rounds without a difference, {seconds:.2f} s undisturbed, seed {SEED}: {dict(seen)}")


if __name__ == "__main__":
    main()
