"""Sweeps by executor, and a sweep of 10,000 members: the figures of docs/scale.md.

PYTHONPATH=.:tests:benchmarks .venv/bin/python benchmarks/scale.py [--write docs/scale.md]

Tells each figure. They are kept in build/benchmarks/scale.json: interrupted, the same command goes
on, as long as neither the solver nor the numbers of members have changed.
"""

import argparse
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

from harness.dask_cluster import Cluster
from harness.mpi_samples import ranks, with_mpi
from processes import Cost, cost, cost_of
from scale_cases import checked, sweep
from scale_page import write
from scale_steps import data_sha256, finished, steps

from plymotion.solver.inputs.case.record import solver_sha256

JSON = Path("build/benchmarks/scale.json")
WORKERS = (1, 2)
WARM = 16  # members that workers of dask compute before: their code is loaded
ALLOWED = (0, 3)

Figure = dict[str, Any]


def local(file: Path, out: Path, workers: int) -> Cost:
    """By processes of this machine."""
    return cost(sweep(file, out, "--fresh", "--jobs", str(workers)), ALLOWED)


def dask(file: Path, out: Path, workers: int) -> Cost:
    """By workers of dask that have worked before."""
    small, _ = checked(out / "warm", WARM)
    cluster = Cluster(out)
    where = ("--fresh", "--scheduler", str(cluster.file))
    try:
        processes = [cluster.worker() for _ in range(workers)]
        for _ in processes:
            cost(sweep(small, out / "warm", *where), ALLOWED)
        before = sum(map(_cpu_s, processes))
        used = cost(sweep(file, out, *where), ALLOWED)
        more = sum(map(_cpu_s, processes)) - before
        return Cost(used.cpu_s + more, used.wall_s, used.peak_mb, used.told)
    finally:
        cluster.close()


def mpi(file: Path, out: Path, workers: int) -> Cost:
    """By so many ranks of MPI besides the one that distributes."""
    path = with_mpi(out / "site")
    if path is None:
        raise FileNotFoundError("no mpirun, or no mpi4py for this Python")
    before = os.environ.get("PYTHONPATH", "")
    os.environ["PYTHONPATH"] = path
    words = ("sweep", str(file), "--quiet", "--no-figures", "--out", str(out), "--fresh")
    try:
        return cost_of(ranks(workers + 1, *words), ALLOWED)
    finally:
        os.environ["PYTHONPATH"] = before


def _cpu_s(process: "subprocess.Popen[bytes]") -> float:
    fields = Path(f"/proc/{process.pid}/stat").read_text().rpartition(")")[2].split()
    return sum(map(int, fields[11:13])) / os.sysconf("SC_CLK_TCK")


class Figures:
    """Figures that are kept as soon as they are known."""

    def __init__(self, about: Figure) -> None:
        self.known: Figure = {"about": about}
        if JSON.is_file():
            earlier = json.loads(JSON.read_text(encoding="utf-8"))
            if earlier["about"] == about:
                self.known = earlier

    def get(self, name: str, measure: Callable[[], Figure]) -> None:
        """Measure what is not known."""
        if name not in self.known:
            load = os.getloadavg()[0]
            self.known[name] = measure() | {"load": load}
            JSON.parent.mkdir(parents=True, exist_ok=True)
            part = JSON.with_suffix(".part")
            part.write_text(json.dumps(self.known, indent=1) + "\n", encoding="utf-8")
            part.replace(JSON)
            told = {key: value for key, value in self.known[name].items() if key != "told"}
            print(f"{name}: {told}", flush=True)


def by_executor(figures: Figures, folder: Path, count: int, repeats: int) -> None:
    """All executors in turn, so that other work on the machine meets all of them."""
    file, _ = checked(folder / "case", count)
    for repeat in range(repeats):
        for compute in (local, dask, mpi):
            for workers in WORKERS:
                name = f"{compute.__name__} {workers} #{repeat}"

                def measure(by: Callable[..., Cost] = compute, workers: int = workers) -> Figure:
                    with tempfile.TemporaryDirectory(dir=folder) as out:
                        used = by(file, Path(out), workers)
                        return asdict(used) | {"data": data_sha256(Path(out) / "sweep.h5")}

                try:
                    figures.get(name, measure)
                except FileNotFoundError as error:
                    print(f"{name}: {error}")


def large(figures: Figures, folder: Path, count: int) -> None:
    """Check of many members, their sweep, interrupted in the middle, and another start."""
    file, used = checked(folder / "case", count)
    out = folder / "out"
    h5, middle = out / "sweep.h5", folder / "half.h5"
    words = sweep(file, out, "--jobs", "2")
    figures.get("check", lambda: asdict(used) | {"file": file.stat().st_size})

    def half() -> Figure:
        h5.unlink(missing_ok=True)

        def interrupt(process: "subprocess.Popen[str]") -> None:
            while process.poll() is None and finished(h5) < count // 2:
                time.sleep(0.5)
            process.send_signal(signal.SIGTERM)

        found = asdict(cost_of([sys.executable, *words], (143,), interrupt))
        shutil.copy(h5, middle)
        return found

    def rest() -> Figure:
        shutil.copy(middle, h5)  # a measurement that was interrupted has gone on
        before = finished(h5)
        used = cost(words, ALLOWED)
        return asdict(used) | {"before": before, "file": h5.stat().st_size}

    if not middle.is_file():  # removed
        figures.known.pop("first half", None)
        figures.known.pop("second half", None)
    figures.get("first half", half)
    figures.get("second half", rest)
    for repeat in range(3):
        figures.get(f"finished #{repeat}", lambda: asdict(cost(words, ALLOWED)))
    figures.get("steps", lambda: steps(file, h5))


def main() -> None:
    """Measure what is not known yet."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--members", type=int, default=512, help="of each executor")
    parser.add_argument("--large", type=int, default=10_000, help="members of the large sweep")
    parser.add_argument("--repeats", type=int, default=3, help="of each executor")
    parser.add_argument("--write", type=Path, metavar="PAGE", help="renew its tables")
    options = parser.parse_args()
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    begin = time.perf_counter()
    about = {"solver": solver_sha256(), "members": options.members, "large": options.large}
    figures = Figures(about | {"repeats": options.repeats})
    cost(["-m", "plymotion", "compile"])
    folder = JSON.parent.resolve() / "scale"
    by_executor(figures, folder / "executors", options.members, options.repeats)
    large(figures, folder / "large", options.large)
    if options.write is not None:
        write(figures.known, options.write)
    print(f"{time.perf_counter() - begin:.0f} s", file=sys.stderr)


if __name__ == "__main__":
    main()
