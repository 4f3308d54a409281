#!/usr/bin/env python3
"""Disturbs batches at random moments, starts them again, and compares the tree with that of an undisturbed run.

    batch_kill.py LAMELLA          rounds by BATCH_KILLS (5), random numbers by BATCH_SEED (of the clock)

A round disturbs one batch up to three times: kill -9 of the batch or of one of its processes, SIGTERM, or writes that fail as on a
full disk. Then it runs to its end, and every byte must be as if nothing had happened.
"""

import os
import pathlib
import random
import resource
import shutil
import subprocess
import sys
import tempfile
import time

ROUNDS = int(os.environ.get("BATCH_KILLS", "5"))
SEED = int(os.environ.get("BATCH_SEED", str(time.time_ns() % 10**9)))
TOOL = str(pathlib.Path(sys.argv[1]).resolve())
BATCH = ["batch", "in", "large.jsonl", "-o", "out/{dir}/{stem}.csv", "--to", "csv,svg,jsonl", "--jobs", "2", "--progress", "never"]
OUT = pathlib.Path("out")


def start(*words):
    return subprocess.Popen([TOOL, *words], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def make_meshes():
    pathlib.Path("in/sub").mkdir(parents=True)
    shapes = {f"in/{'sub/' if i % 4 == 0 else ''}m{i}.stl": (("sphere", "torus", "bone")[i % 3], 500 * (i + 1)) for i in range(24)}
    shapes.update({f"large{i}.stl": ("bone", 200_000) for i in range(3)})
    for name, (shape, triangles) in shapes.items():
        start("make", shape, "--triangles", str(triangles), "--height", "40", "-o", name).wait()
    pathlib.Path("in/bad.stl").write_text("no mesh\n")
    rest = '"spacing":[0.4,0.4,0.4],"frame":"lps","output":"out/masks/{stem}.nii.gz","to":"nii.gz,seg.nrrd,csv"}\n'
    pathlib.Path("large.jsonl").write_text("".join(f'{{"path":"large{i}.stl",{rest}' for i in range(3)))


def tree():
    return {str(path): path.read_bytes() for path in OUT.rglob("*") if path.is_file()}


def kill(batch, pause):
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
        running = subprocess.run(["pgrep", "-P", str(batch.pid)], stdout=subprocess.PIPE, text=True, check=False).stdout.split()
        if running:
            subprocess.run(["kill", "-9", random.choice(running)], stderr=subprocess.DEVNULL, check=False)


def full_disk(batch, _):
    """No file may become larger than some that the batch writes."""
    largest = random.choice([1000, 10_000, 100_000])
    resource.prlimit(batch.pid, resource.RLIMIT_FSIZE, (largest, largest))


KINDS = [kill_while_writing, kill, terminate, kill_processes, full_disk]


def main():
    random.seed(SEED)
    folder = tempfile.mkdtemp(prefix="batch_kill.")
    os.chdir(folder)
    make_meshes()
    begun = time.monotonic()
    assert start(*BATCH).wait() == 5, "the undisturbed run has another exit status"
    seconds = time.monotonic() - begun
    whole = tree()
    for number in range(ROUNDS):
        shutil.rmtree(OUT)
        kinds = [KINDS[number % len(KINDS)], *random.choices(KINDS, k=random.randint(0, 2))]
        for disturb in kinds:
            batch = start(*BATCH)
            disturb(batch, lambda: time.sleep(random.uniform(0, seconds)))
            batch.wait()
        status, found = start(*BATCH).wait(), tree()
        different = [name for name in sorted({*found, *whole}) if found.get(name) != whole.get(name)]
        print(f"round {number}, seed {SEED}:", *(kind.__name__ for kind in kinds))
        if status != 5 or different:
            sys.exit(f"FAILED: exit status {status}, different: {different[:10]}; see {folder}")
    shutil.rmtree(folder)


if __name__ == "__main__":
    main()
