"""What the command of a sweep does for each member besides computing it; data of its file."""

import hashlib
import tempfile
import time
from concurrent.futures import Future
from pathlib import Path
from typing import Any

import h5py

from plymotion.solver.studies.sweep.file import believed_rows, result_of, write_sweep
from plymotion.solver.studies.sweep.sweep_members import read_sweep_spec
from plymotion.solver.workers.executors import Task, distribute

DIFFERENT = ("cost/solve_s", "members/sha256")  # between two computations
LANES = (2, 6400)
TASKS = 100_000


def finished(file: Path) -> int:
    """Return how many members of a sweep.h5 are finished, 0 without one."""
    if not file.is_file():
        return 0
    with h5py.File(file) as h5:
        return sum(status == b"finished" for status in h5["members/status"][()])


def data_sha256(file: Path) -> str:
    """Return the hash of all data of a sweep.h5 but the times that members took."""
    digest = hashlib.sha256()

    def note(name: str, item: object) -> None:
        if isinstance(item, h5py.Dataset) and name not in DIFFERENT:
            digest.update(name.encode())
            values = item[()]
            digest.update(repr(values.tolist()).encode() if values.dtype == object else values)

    with h5py.File(file) as h5:
        h5.visititems(note)
    return digest.hexdigest()


def steps(file: Path, h5: Path) -> dict[str, Any]:
    """Return the CPU time of each step of the command [s], and portions per second of its loop."""
    begin = time.process_time()
    plan = read_sweep_spec(file)
    read = time.process_time()
    keys = plan.keys()
    identified = time.process_time()
    known, _ = believed_rows(h5)
    verified = time.process_time()
    with tempfile.TemporaryDirectory() as folder:
        write_sweep(Path(folder) / "sweep.h5", result_of(plan, [known[key] for key in keys]))
    saved = time.process_time()
    return {
        "read": read - begin,
        "identified": identified - read,
        "verified": verified - identified,
        "saved": saved - verified,
        "portions per second": {lanes: _portions(lanes) for lanes in LANES},
    }


class _Instant:
    """An executor that takes no time."""

    name = "instant"
    lost: tuple[type[BaseException], ...] = ()

    def __init__(self, lanes: int) -> None:
        self._lanes = lanes

    def width(self) -> int:
        return self._lanes

    def submit(self, lane: int, function: Any, *arguments: Any) -> "Future[Any]":
        future: Future[Any] = Future()
        future.set_result(None)
        return future

    def close(self, *, at_once: bool) -> None:
        pass


class _Tasks:
    """A number of tasks."""

    def __init__(self) -> None:
        self._left = TASKS

    def next(self, lane: int, width: int) -> Task | None:
        self._left -= 1
        return Task(print, ()) if self._left >= 0 else None

    def took(self, task: Task, result: Any) -> None:
        pass

    def lost(self, task: Task) -> None:
        raise AssertionError


def _portions(lanes: int) -> float:
    begin = time.process_time()
    distribute(_Instant(lanes), _Tasks())
    return TASKS / (time.process_time() - begin)
