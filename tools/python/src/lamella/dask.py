"""Many meshes on the workers of a Dask scheduler, one process of the command line tool for each.

    client = distributed.Client("scheduler:8786")
    many = lamella.dask.slice_many(client, paths, "masks/{stem}.nii.gz", spacing=(1, 1, 2), frame="lps")
    many.frame()                                   # waits; a pandas DataFrame, a row for each mesh

Workers need this package, the program ``lamella`` and the files at the paths that the client names. The tool writes the
outputs, so that they are the bytes that one machine writes, and a mesh that ends its process does not end the worker.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import uuid
from concurrent.futures import CancelledError
from typing import TYPE_CHECKING, Any, Callable, Dict, Iterator, List, Mapping, Optional, Sequence, Tuple, Union

from ._errors import Error, InvalidArgumentError

if TYPE_CHECKING:
    import distributed
    import pandas

__all__ = ["LostItemError", "Many", "slice_many"]

PathLike = Union[str, "os.PathLike[str]"]
MemoryLike = Union[None, str, int, Callable[[str], int]]
Row = Dict[str, Any]

MESH_ENDS = (".stl", ".obj", ".off", ".ply", ".vtk", ".vtp", ".3mf")
DECIDED_BY_MESH = (2, 3)
"""Exit statuses of the tool that another try would not change: usage, and input that cannot be used."""


class LostItemError(Error):
    """The tool was killed, found no room for its output, took too long, or is missing on the worker: another try may do."""

    code = "lost_item"


class Many:
    """What `slice_many` has begun: a future for each mesh, and the table that they make.

    Attributes
    ----------
    paths : list of str
        The meshes, in the order in which they were given.
    futures : list of distributed.Future
        In the same order. The result of each is its row, as in `rows`. It raises `LostItemError` if every try was lost, and
        ``distributed.KilledWorker`` if its workers were.
    """

    def __init__(self, paths: List[str], futures: List[distributed.Future]) -> None:
        self.paths = paths
        self.futures = futures

    def __len__(self) -> int:
        return len(self.futures)

    def __iter__(self) -> Iterator[distributed.Future]:
        return iter(self.futures)

    def __repr__(self) -> str:
        futures: List[Any] = self.futures  # distributed types a part of its calls only
        ended = sum(future.done() for future in futures)
        return f"<lamella.dask.Many: {ended:,} of {len(self):,} meshes>"

    def rows(self) -> List[Row]:
        """Waits for all meshes. A row for each, in their order; none of them depends on which worker did it, or how often.

        ``mesh`` is its path and ``reason`` is empty, or why there is no result; then what the tool's report says: the number of
        ``triangles``, ``layers``, ``contours`` and ``open`` ones, ``volume_mm3``, ``certificate``, ``hash`` and ``warnings``.
        """
        return [_row_of(path, future) for path, future in zip(self.paths, self.futures)]

    def frame(self) -> pandas.DataFrame:
        """The same as a pandas DataFrame."""
        import pandas

        return pandas.DataFrame(self.rows(), columns=list(_row("", {}, "")))

    def cancel(self) -> None:
        """Takes back what has not begun."""
        futures: List[Any] = self.futures
        for future in futures:
            future.cancel()


def slice_many(
    client: distributed.Client,
    paths: Sequence[PathLike],
    output: str,
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
    output : str
        What to write, ``{stem}`` being a mesh's name without its ends: ``"masks/{stem}.nii.gz"``. Folders are made.
    memory : "auto", int, callable or None
        Bytes that a mesh takes of the resource MEMORY of its worker (``dask worker --resources MEMORY=8e9``), so that no
        worker has more at once than fit; or a function of the path. "auto": estimated from the file's size, if workers have
        that resource. None: nothing is asked for.
    retries : int
        How often a mesh is tried again whose process was killed, ran out of time or could not write. Those of lost
        workers are tried again whatever it is, as often as the scheduler's ``allowed-failures`` says.
    timeout : float, optional
        Seconds after which a try is ended.
    threads : int
        Of the tool, for each mesh.
    tool : str
        The program on the workers.
    folder : path, optional
        What relative paths are relative to, on every worker; the client's own current folder without it.
    **options
        Those of ``lamella slice`` by their names: ``layer_height=0.5``, ``to="nii.gz,csv"``, ``spacing=(1, 1, 2)``,
        ``strict=True``.

    Returns
    -------
    Many
        Its futures have been submitted.

    Raises
    ------
    InvalidArgumentError
        Two meshes have one output, no worker has the memory asked for, or a value cannot be said to the tool.
    """
    names = [os.fspath(path) for path in paths]
    outputs = _outputs(names, output)
    words = [*_words(options), f"--threads={threads}"]
    where = os.path.abspath(os.fspath(folder) if folder is not None else os.getcwd())
    scheduler: Any = client
    needs = _needs(names, where, memory, scheduler.scheduler_info()["workers"])
    call = uuid.uuid4().hex
    futures = [
        scheduler.submit(
            _slice_one,
            name,
            outputs[i],
            words,
            tool,
            where,
            timeout,
            key=f"lamella-slice-{call}-{i}",
            retries=retries,
            resources={"MEMORY": needs[i]} if needs[i] else None,
        )
        for i, name in enumerate(names)
    ]
    return Many(names, futures)


def _stem(path: str) -> str:
    name = os.path.basename(path)
    if name.lower().endswith(".gz"):
        name = name[:-3]
    return name[:-4] if name.lower().endswith(MESH_ENDS) else name


def _outputs(paths: Sequence[str], pattern: str) -> List[str]:
    if "{stem}" not in pattern and len(paths) > 1:
        raise InvalidArgumentError(f"output must contain {{stem}}, so that each mesh has its own: {pattern!r}")
    outputs = [pattern.replace("{stem}", _stem(path)) for path in paths]
    of: Dict[str, str] = {}
    for path, output in zip(paths, outputs):
        if output in of:
            raise InvalidArgumentError(f"{of[output]} and {path} have one output: {output}")
        of[output] = path
    return outputs


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
    """Of the resource MEMORY, for each mesh; 0: nothing is asked for."""
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


def _row(path: str, report: Mapping[str, Any], reason: str) -> Row:
    return {
        "mesh": path,
        "reason": reason,
        "triangles": report.get("triangles"),
        "layers": report.get("planes"),
        "contours": report.get("contours"),
        "open": report.get("open_contours"),
        "volume_mm3": report.get("volume", {}).get("mesh_mm3"),
        "certificate": report.get("volume", {}).get("verdict"),
        "hash": report.get("output_hash"),
        "warnings": report.get("warnings"),
    }


def _row_of(path: str, future: Any) -> Row:
    try:
        row: Row = future.result()
    except CancelledError:
        return _row(path, {}, "cancelled")
    except Exception as error:  # whatever ends one mesh must not hide the rows of the others
        killed = type(error).__name__ == "KilledWorker"
        return _row(path, {}, "every worker that it was given to was lost" if killed else str(error))
    return row


def _slice_one(path: str, output: str, words: List[str], tool: str, folder: str, timeout: Optional[float]) -> Row:
    """Runs on the worker, in the client's folder: records beside outputs name their inputs as the client does."""
    program = shutil.which(tool)
    if program is None:
        raise LostItemError(f"the worker has no program {tool!r}")
    try:
        os.makedirs(os.path.dirname(os.path.join(folder, output)), exist_ok=True)
        status, said, complaint = _run([program, "slice", path, "-o", output, *words, "--report", "-"], folder, timeout)
    except subprocess.TimeoutExpired:
        raise LostItemError(f"not done after {timeout} s") from None
    except OSError as error:
        raise LostItemError(str(error)) from None
    if status in DECIDED_BY_MESH:
        return _row(path, {}, complaint)
    if status != 0:
        raise LostItemError(complaint if status > 0 else f"killed by signal {-status}")
    return _row(path, json.loads(said), "")


def _run(command: List[str], folder: str, timeout: Optional[float]) -> Tuple[int, bytes, str]:
    """Exit status, standard output, and the last line of what was said on stderr. The tool ends with its worker: if that is
    killed, its memory counts for the next one at once."""
    setpriv = shutil.which("setpriv")
    guard = [setpriv, "--pdeathsig", "TERM"] if setpriv is not None else []
    run = subprocess.run(
        [*guard, *command], cwd=folder, stdin=subprocess.DEVNULL, capture_output=True, timeout=timeout, check=False
    )
    lines = run.stderr.decode(errors="replace").strip().splitlines() or [f"exit status {run.returncode}"]
    return run.returncode, run.stdout, lines[-1].removeprefix("lamella: ")
