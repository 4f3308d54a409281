#!/usr/bin/env python3
"""Disturbs batches at random moments, starts them again, and compares the tree with that of an undisturbed run.

    batch_kill.py LAMELLA          rounds by BATCH_KILLS (5), random numbers by BATCH_SEED (of the clock)

A round disturbs one batch up to three times: kill -9 of the batch or of one of its processes, SIGTERM, or a full disk (a small
tmpfs where one may be mounted, else a limit on the size of files). Then it runs to its end, and every byte must be as if nothing
had happened.
"""

import collections
import os
import pathlib
import random
import resource
import signal
import subprocess
import sys
import tempfile
import time

ROUNDS = int(os.environ.get("BATCH_KILLS", "5"))
SEED = int(os.environ.get("BATCH_SEED", str(time.time_ns() % 10**9)))
SMALL, LARGE = 24, 3
FAR_SIZE = "512m"


def run(*command, **options):
    return subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False, **options).returncode


def tree(folder):
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


def children(process):
    try:
        return [int(word) for word in pathlib.Path(f"/proc/{process}/task/{process}/children").read_text().split()]
    except OSError:
        return []


def kill(process, number):
    try:
        os.kill(process, number)
    except ProcessLookupError:
        pass


class Rounds:
    def __init__(self, lamella, folder):
        self.random = random.Random(SEED)
        self.folder = folder
        self.out = folder / "out"
        self.command = [lamella, "batch", "in", "large.jsonl", "-o", "out/{dir}/{stem}.csv", "--to", "csv,svg,jsonl",
                        "--jobs", "2", "--retries", "1", "--progress", "never"]  # fmt: skip
        self.mounted = False
        self.mounts = 0

    def make_meshes(self, lamella):
        (self.folder / "in/sub").mkdir(parents=True)
        for i in range(SMALL):
            shape = ("sphere", "torus", "bone")[i % 3]
            name = self.folder / "in" / ("sub" if i % 4 == 0 else "") / f"m{i}.stl"
            run(lamella, "make", shape, "--triangles", str(500 * (i + 1)), "--height", "40", "-o", str(name))
        (self.folder / "in/bad.stl").write_text("no mesh\n")
        rows = []
        for i in range(LARGE):
            run(lamella, "make", "bone", "--triangles", "200000", "--height", "60", "-o", str(self.folder / f"large{i}.stl"))
            rows.append(f'{{"path":"large{i}.stl","spacing":[0.4,0.4,0.4],"frame":"lps","output":"out/masks/{{stem}}.nii.gz",'
                        '"to":"nii.gz,seg.nrrd,csv"}\n')  # fmt: skip
        (self.folder / "large.jsonl").write_text("".join(rows))

    def undisturbed(self):
        start = time.monotonic()
        status = run(*self.command, cwd=self.folder)
        self.seconds = time.monotonic() - start
        assert status == 5, f"the undisturbed run: exit status {status}"
        self.whole = tree(self.out)
        self.bytes = sum(len(content) for content in self.whole.values())

    def clear(self):
        if self.mounted:
            subprocess.run(["umount", str(self.out)], check=True)
            self.mounted = False
        run("rm", "-rf", str(self.out))
        self.out.mkdir()

    def start(self, **options):
        return subprocess.Popen(self.command, cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, **options)

    def pause(self):
        time.sleep(self.random.uniform(0, self.seconds))

    def kill_batch(self):
        batch = self.start()
        self.pause()
        batch.kill()
        batch.wait()

    def kill_while_writing(self):
        """When a file that is being written aside is seen."""
        batch = self.start()
        until = time.monotonic() + self.random.uniform(0, self.seconds)
        while batch.poll() is None and (time.monotonic() < until or not any(self.out.rglob(".*.part"))):
            pass
        batch.kill()
        batch.wait()

    def terminate(self):
        batch = self.start()
        self.pause()
        batch.terminate()
        batch.wait()

    def kill_processes(self):
        batch = self.start()
        for _ in range(self.random.randint(1, 4)):
            self.pause()
            running = children(batch.pid)
            if running:
                kill(self.random.choice(running), signal.SIGKILL)
        batch.wait()

    def full_disk(self):
        size = int(self.bytes * self.random.uniform(0.05, 1.05))
        if not self.mounted and not any(self.out.iterdir()):
            self.mounted = run("mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", str(self.out)) == 0
            self.mounts += self.mounted
        elif self.mounted and run("mount", "-o", f"remount,size={size}", str(self.out)) != 0:
            return  # more is in there already
        if self.mounted:
            self.start().wait()
            subprocess.run(["mount", "-o", f"remount,size={FAR_SIZE}", str(self.out)], check=True)
            return
        largest = self.random.randint(1, max(map(len, self.whole.values())))
        self.start(preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (largest, largest))).wait()

    def round(self, number):
        self.clear()
        kinds = [self.kill_while_writing, self.kill_batch, self.terminate, self.kill_processes, self.full_disk]
        first = kinds[number % len(kinds)]
        done = [first, *self.random.choices(kinds, k=self.random.randint(0, 2))]
        for disturb in done:
            disturb()
        status = run(*self.command, cwd=self.folder)
        names = ", ".join(kind.__name__ for kind in done)
        found = tree(self.out)
        different = [name for name in sorted({*found, *self.whole}) if found.get(name) != self.whole.get(name)]
        if status != 5 or different:
            print(f"FAILED: round {number}, seed {SEED}: {names}: exit status {status}, different: {different[:10]}")
            print(f"the tree is in {self.folder}")
        return names, status == 5 and not different


def main():
    lamella = str(pathlib.Path(sys.argv[1]).resolve())
    folder = pathlib.Path(tempfile.mkdtemp(prefix="batch_kill."))
    rounds = Rounds(lamella, folder)
    rounds.make_meshes(lamella)
    rounds.undisturbed()
    seen = collections.Counter()
    for number in range(ROUNDS):
        names, same = rounds.round(number)
        if not same:
            return 1
        seen.update(names.split(", "))
    rounds.clear()
    run("rm", "-rf", str(folder))
    print(f"{ROUNDS} rounds without a difference, {rounds.seconds:.2f} s undisturbed, seed {SEED}: {dict(seen)}, "
          f"{rounds.mounts} on a full tmpfs")  # fmt: skip
    return 0


if __name__ == "__main__":
    sys.exit(main())
