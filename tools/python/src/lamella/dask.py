"""Many meshes on the workers of a Dask scheduler, each done by the command line tool as a shard of one batch.

    client = distributed.Client("scheduler:8786")
    many = lamella.dask.slice_many(client, paths, "masks/{stem}.nii.gz", spacing=(1, 1, 2), frame="lps")
    many.frame()                                   # waits; a pandas DataFrame, a row for each mesh

Workers need this package, the program ``lamella`` and the files at the paths that the client names. ``lamella batch`` writes
the outputs and what came of each mesh, so that they are the bytes that one machine writes; a mesh that ends its process does
not end the worker; and what was done before is not done again.
"""

from __future__ import annotations

import csv
import json
import os
import shutil
import subprocess
import tempfile
import uuid
from concurrent.futures import CancelledError
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Callable, Dict, Iterator, List, Mapping, Optional, Sequence, Union

from ._errors import Error, InvalidArgumentError
from ._tool import find_tool

if TYPE_CHECKING:
    import distributed
    import pandas

__all__ = ["LostItemError", "Many", "slice_many"]

PathLike = Union[str, "os.PathLike[str]"]
MemoryLike = Union[None, str, int, Callable[[str], int]]
Row = Dict[str, Any]

COLUMNS = ("mesh", "status", "reason", "triangles", "layers", "contours", "open_contours", "warnings", "outputs")
SOME_FAILED = 5
REFUSED = (2, 3)
"""Exit statuses of a batch that another try would not change: what was asked for is wrong."""


class LostItemError(Error, code="lost_item"):
    """The batch of a mesh was killed, could not write, or has no program on the worker: another try may do."""


@dataclass(eq=False, repr=False)
class Many:
    """Slices that `slice_many` has begun: a future for each mesh, and the table that they make.

    Attributes
    ----------
    paths : list of str
        The meshes, in the order in which they were given.
    futures : list of distributed.Future
        In the same order. The result of each is its row, as in `rows`. It raises `LostItemError` if every try was lost, and
        ``distributed.KilledWorker`` if its workers were.
    joined : distributed.Future
        The path of results.jsonl, in which the rows of all meshes are joined when the last one has ended.
    """

    paths: List[str]
    futures: List[distributed.Future]
    joined: distributed.Future

    def __len__(self) -> int:
        return len(self.futures)

    def __iter__(self) -> Iterator[distributed.Future]:
        return iter(self.futures)

    def __repr__(self) -> str:
        futures: List[Any] = self.futures  # distributed types a part of its calls only
        ended = sum(future.done() for future in futures)
        return f"<lamella.dask.Many: {ended:,} of {len(self):,} meshes>"

    def rows(self) -> List[Row]:
        """Waits for all meshes. A row for each, in their order: its line of results.jsonl.

        ``mesh`` is its path, ``status`` "done" or "failed" with the ``reason``. Rows do not depend on which worker did them, or
        how often.

        Raises
        ------
        InvalidArgumentError
            What was asked for is wrong, for one mesh as for all.
        """
        rows = [_row_of(path, future) for path, future in zip(self.paths, self.futures)]
        if all("outputs" in row for row in rows):  # else a part is missing, and its row says why
            joined: Any = self.joined
            joined.result()
        return rows

    def frame(self) -> pandas.DataFrame:
        """The same as a pandas DataFrame."""
        import pandas

        return pandas.DataFrame([{name: row.get(name) for name in COLUMNS} for row in self.rows()], columns=list(COLUMNS))

    def cancel(self) -> None:
        """Takes back what has not begun."""
        futures: List[Any] = [self.joined, *self.futures]
        for future in futures:
            future.cancel()


def slice_many(
    client: distributed.Client,
    paths: Sequence[PathLike],
    output: Union[str, Sequence[str]],
    *,
    memory: MemoryLike = "auto",
    retries: int = 2,
    timeout: Optional[float] = None,
    threads: int = 1,
    tool: str = "lamella",
    folder: Optional[PathLike] = None,
    **options: Any,
) -> Many:
    """Slice many meshes on the workers of a Dask scheduler.

    Parameters
    ----------
    client : distributed.Client
        The scheduler. It gives meshes of lost workers to others.
    paths : sequence of path
        One mesh each, as the workers reach it.
    output : str or sequence of str
        What to write, ``{stem}`` being a mesh's name without its ends: ``"masks/{stem}.nii.gz"``. Folders are made. The
        folder before the first ``{`` gets results.jsonl.
    memory : "auto", int, callable or None
        Bytes that a mesh takes of the resource MEMORY of its worker (``dask worker --resources MEMORY=8e9``), so that no
        worker has more at once than fit; or a function of the path. "auto": estimated from the file's size, if workers have
        that resource. None: nothing is asked for.
    retries : int
        How often a mesh is tried again whose process was killed or ran out of time, and a worker's batch that was killed
        or could not write. Those of lost workers are tried again whatever it is, as often as the scheduler's
        ``allowed-failures`` says.
    timeout : float, optional
        Seconds after which a try is ended.
    threads : int
        For each mesh.
    tool : str
        The program on the workers: where it is not on their path, the one that came with their package.
    folder : path, optional
        What relative paths are relative to, on every worker; the client's own current folder without it.
    **options
        Those of ``lamella batch`` by their names: ``layer_height=0.5``, ``to="nii.gz,csv"``, ``spacing=(1, 1, 2)``,
        ``strict=True``, ``force=True``.

    Returns
    -------
    Many
        Its futures have been submitted. Meshes that are done already, as results.jsonl and the outputs say, are not done
        again.

    Raises
    ------
    InvalidArgumentError
        No worker has the memory asked for, or a value cannot be said to the tool.
    """
    names = [os.fspath(path) for path in paths]
    where = os.path.abspath(os.fspath(folder) if folder is not None else os.getcwd())
    outputs = [output] if isinstance(output, str) else list(output)
    words = [*(f"--output={each}" for each in outputs), *_words(options), f"--jobs={threads}", f"--retries={retries}"]
    words += [f"--timeout={timeout}"] if timeout is not None else []
    results = options.get("results") or (os.path.dirname(outputs[0].split("{")[0]) if outputs else "") or "."
    batch = _Batch(tool, where, str(results), words, len(names))
    scheduler: Any = client
    needs = _needs(names, where, memory, scheduler.scheduler_info()["workers"])
    call = f"lamella-slice-{uuid.uuid4().hex}"
    # A task of its own, and not an argument of each: were it lost with its worker, it would be made again.
    listed = scheduler.submit(list, names, key=f"{call}-paths")
    futures = [
        scheduler.submit(batch.slice_one, listed, i, need, key=f"{call}-{i}", retries=retries, resources={"MEMORY": need} if need else None)
        for i, need in enumerate(needs)
    ]
    return Many(names, futures, scheduler.submit(batch.join, futures, key=f"{call}-join", retries=retries))


def _words(options: Mapping[str, Any]) -> List[str]:
    words: List[str] = []
    for name, value in options.items():
        option = "--" + name.replace("_", "-")
        if value is True:
            words.append(option)
        elif isinstance(value, (str, int, float, os.PathLike)) and value is not False:
            words.append(f"{option}={os.fspath(value) if isinstance(value, os.PathLike) else value}")
        elif isinstance(value, (list, tuple)) and all(isinstance(part, str) for part in value):
            words += [f"{option}={part}" for part in value]
        elif isinstance(value, (list, tuple)):
            words.append(f"{option}=" + ",".join(str(part) for part in value))
        elif value is not None and value is not False:
            raise InvalidArgumentError(f"{name} must be a number, a word, True, or a list of these, not {value!r}")
    return words


def _estimate(path: str) -> int:
    """Bytes that slicing takes: of what the tool holds, the file and 48 bytes a triangle are most."""
    try:
        size = os.path.getsize(path)
    except OSError:
        size = 0  # the worker says what is wrong with it
    return 256 * 2**20 + size * (16 if path.lower().endswith((".gz", ".3mf")) else 4)


def _needs(paths: Sequence[str], folder: str, memory: MemoryLike, workers: Mapping[str, Any]) -> List[int]:
    """The share of the resource MEMORY for each mesh; 0: nothing is asked for."""
    of_workers = [worker["resources"]["MEMORY"] for worker in workers.values() if "MEMORY" in worker.get("resources", {})]
    if memory is None or (memory == "auto" and not of_workers):
        return [0] * len(paths)
    if isinstance(memory, str):
        if memory != "auto":
            raise InvalidArgumentError(f"memory must be 'auto', bytes, a function of the path or None, not {memory!r}")
        largest = int(max(of_workers))
        return [min(_estimate(os.path.join(folder, path)), largest) for path in paths]
    needs = [int(memory(path)) if callable(memory) else int(memory) for path in paths]
    for path, need in zip(paths, needs):
        if workers and need > max(of_workers, default=0):
            raise InvalidArgumentError(f"{path}: no worker has MEMORY={need} (dask worker --resources MEMORY=BYTES)")
    return needs


def _row_of(path: str, future: Any) -> Row:
    try:
        row: Row = future.result()
        return row
    except InvalidArgumentError:
        raise
    except Exception as error:  # whatever ends one mesh must not hide the rows of the others
        lost = "every worker that it was given to was lost" if type(error).__name__ == "KilledWorker" else str(error)
        return {"mesh": path, "status": "failed", "reason": "cancelled" if isinstance(error, CancelledError) else lost}


@dataclass
class _Batch:
    """The work of workers: one shard for each mesh, in the client's folder, since records name inputs as the client does."""

    tool: str
    folder: str
    results: str
    words: List[str]
    shards: int

    def part(self, shard: int) -> str:
        return os.path.join(self.folder, self.results, f"results.{shard}-of-{self.shards}.jsonl")

    def slice_one(self, paths: Sequence[str], shard: int, memory: int) -> Row:
        """The row of the mesh, done or failed. Raises LostItemError where another try may do."""
        granted = [f"--memory={memory}"] if memory else []
        with tempfile.TemporaryDirectory() as scratch:
            manifest = os.path.join(scratch, "meshes.csv")
            with open(manifest, "w", newline="", errors="surrogateescape") as file:
                csv.writer(file, quoting=csv.QUOTE_ALL).writerows([["path"], *([path] for path in paths)])
            self.run([manifest, *self.words, *granted, f"--shard={shard}/{self.shards}"])
        with open(self.part(shard), errors="replace") as file:
            row: Row = json.loads(file.readline())
        return row

    def join(self, rows: Sequence[Row]) -> str:
        """Joins the results of all shards, as one machine writes them. All of them have ended: parts that are missing were
        joined by an earlier try, which was lost before it said so."""
        parts = [self.part(shard) for shard in range(len(rows))]
        present = [part for part in parts if os.path.exists(part)]
        if parts and len(present) == len(parts):
            self.run(["--merge", *parts])
        for part in present:
            os.remove(part)
        return os.path.join(self.folder, self.results, "results.jsonl")

    def run(self, words: List[str]) -> None:
        program = shutil.which(self.tool) or (find_tool() if self.tool == "lamella" else None)
        if program is None:
            raise LostItemError(f"the worker has no program {self.tool!r}")
        # The batch ends with its worker: if that is killed, the memory that it takes counts for others at once.
        setpriv = shutil.which("setpriv")
        guard = [setpriv, "--pdeathsig", "TERM"] if setpriv is not None else []
        command = [*guard, program, "batch", *words]
        ended = subprocess.run(command, cwd=self.folder, stdin=subprocess.DEVNULL, capture_output=True, check=False)
        lines = ended.stderr.decode(errors="replace").strip().splitlines() or [f"exit status {ended.returncode}"]
        complaint = lines[-1].removeprefix("lamella: ")
        if ended.returncode in REFUSED:
            raise InvalidArgumentError(complaint)
        if ended.returncode not in (0, SOME_FAILED):
            raise LostItemError(complaint if ended.returncode > 0 else f"the batch was killed by signal {-ended.returncode}")
