"""Sweeps by executor: members per second, and what sweeps of many members cost (docs/scale.md).

PYTHONPATH=.:tests:benchmarks .venv/bin/python benchmarks/scale.py pairs | workers | large [N]

pairs: 512 double pendulums of 1 s, by two local processes and by two dask workers at once.
workers: the same by one and two processes, workers, ranks. large: check of N members;
sweep, file and restart of N rigid pendulums.
"""

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import h5py
import numpy as np
from dask_cluster import Cluster
from mpi_samples import ranks, with_mpi
from processes import Cost, cost, cost_of

TEXT = """
[variants.measured.solver]
t_end = {t_end}
output_step = 0.001
rtol = 1e-5
[coarse.sweeps.s]
count = 2
[sweeps.s]
run = "isotropic"
variants = ["measured"]
design = "latin-hypercube"
count = {count}
signals = ["tip_x", "hand_mid"]
[sweeps.s.vary]
"masses.M2.mass" = {{ from = 1.0, to = 4.0 }}
"joints.shoulder.drive.speed" = {{ from = 5.0, to = 20.0 }}
"""
# A rigid pendulum, 0.1 s: cheap members, so that what each member costs besides is seen.
RIGID = """
format = 1
title = "rigid pendulum"
gravity = [0.0, -9.81, 0.0]
[bodies.rod]
kind = "rigid"
mass = 1.0
inertia = [[0.001, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.1]]
centre = [0.5, 0.0, 0.0]
interfaces = {{ root = {{ position = [0.0, 0.0, 0.0] }}, tip = {{ position = [1.0, 0.0, 0.0] }} }}
[ground.o]
position = [0.0, 0.0, 0.0]
[joints.hinge]
kind = "revolute"
between = ["ground.o", "rod.root"]
axis = [0.0, 0.0, 1.0]
[signals.x]
kind = "position"
at = "rod.tip"
component = "x"
[signals.y]
kind = "position"
at = "rod.tip"
component = "y"
[solver]
t_end = 0.1
output_step = 0.01
[runs.base]
[sweeps.s]
run = "base"
design = "latin-hypercube"
count = {count}
[sweeps.s.vary]
"bodies.rod.mass" = {{ from = 1.0, to = 4.0 }}
"bodies.rod.centre.0" = {{ from = 0.4, to = 0.6 }}
"""
PLYMOTION = ("-m", "plymotion")
PACKAGES = Path("tests/packages/double-pendulum")
TIME = ("cost/solve_s", "members/sha256")  # what differs between two computations


def _checked(folder: Path, count: int, t_end: float) -> tuple[Path, Cost]:
    """Check the case of a sweep; its sweep file, and what the check took."""
    text = Path("cases/double-pendulum/case.toml").read_text(encoding="utf-8")
    text = text[: text.index("[variants.fifth.solver]")] + TEXT.format(count=count, t_end=t_end)
    case, out = folder / "case.toml", folder / "build"
    case.write_text(text, encoding="utf-8")
    used = cost([*PLYMOTION, "check", str(case), "--out", str(out), "--packages", str(PACKAGES)])
    return out / "sweeps/s.json", used


def _sweep(file: Path, out: Path, *words: str) -> Cost:
    more = ("--quiet", "--no-figures", "--out", str(out))
    return cost([*PLYMOTION, "sweep", str(file), *more, *words], allowed=(0, 3))


def _cpu_s(process: "subprocess.Popen[bytes]") -> float:
    fields = Path(f"/proc/{process.pid}/stat").read_text().rpartition(")")[2].split()
    return sum(map(int, fields[11:13])) / os.sysconf("SC_CLK_TCK")


def _data(file: Path) -> dict[str, bytes]:
    with h5py.File(file) as h5:
        found: dict[str, bytes] = {}

        def note(name: str, item: object) -> None:
            if isinstance(item, h5py.Dataset) and name not in TIME:
                found[name] = item[()].tobytes()

        h5.visititems(note)
    return found


def _by_dask(cluster: Cluster, workers: list["subprocess.Popen[bytes]"], *where: Path) -> Cost:
    before = sum(map(_cpu_s, workers))
    used = _sweep(*where, "--fresh", "--scheduler", str(cluster.file))
    return Cost(used.cpu_s + sum(map(_cpu_s, workers)) - before, used.wall_s, used.peak_mb)


def pairs(folder: Path, count: int, repeats: int) -> None:
    """Two local processes and two dask workers at once: other work on the machine slows both."""
    file, _ = _checked(folder, count, 1.0)
    (folder / "cluster").mkdir()
    cluster = Cluster(folder / "cluster")
    try:
        workers = [cluster.worker(), cluster.worker()]
        _by_dask(cluster, workers, file, folder / "warm")
        ratios = []
        for _ in range(repeats):
            with ThreadPoolExecutor(2) as pool:
                one = pool.submit(_sweep, file, folder / "local", "--fresh", "--jobs", "2")
                two = pool.submit(_by_dask, cluster, workers, file, folder / "dask")
                local, dask = one.result(), two.result()
            ratios.append((dask.wall_s / local.wall_s, dask.cpu_s / local.cpu_s))
            for name, used in (("local", local), ("dask ", dask)):
                print(f"{name} {_told(used)}", flush=True)
        walls, cpus = zip(*ratios, strict=True)
        print("dask / local: wall " + " ".join(f"{ratio:.2f}" for ratio in walls))
        print(f"median: wall {statistics.median(walls):.2f}, CPU {statistics.median(cpus):.2f}")
        same = _data(folder / "local/sweep.h5") == _data(folder / "dask/sweep.h5")
        print(f"equal to the last bit: {same}")
    finally:
        cluster.close()


def _told(used: Cost) -> str:
    return f"{used.wall_s:.1f} s wall, {used.cpu_s:.1f} s CPU, {used.peak_mb:.0f} MB"


def by_workers(folder: Path, count: int) -> None:
    """Members per second and per CPU second, by one and two workers of each executor."""
    file, _ = _checked(folder, count, 1.0)

    def told(name: str, used: Cost) -> None:
        rates = f"{count / used.wall_s:.1f} /s, {count / used.cpu_s:.1f} /CPU s"
        print(f"{name}: {rates}; load {os.getloadavg()[0]:.1f}", flush=True)

    for jobs in ("1", "2"):
        told(f"local {jobs}", _sweep(file, folder / "local", "--fresh", "--jobs", jobs))
    (folder / "cluster").mkdir()
    cluster = Cluster(folder / "cluster")
    try:
        workers: list[subprocess.Popen[bytes]] = []
        for number in (1, 2):
            workers.append(cluster.worker())
            _by_dask(cluster, workers, file, folder / "dask")
            told(f"dask {number}", _by_dask(cluster, workers, file, folder / "dask"))
    finally:
        cluster.close()
    path = with_mpi(folder / "site")
    if path is None:
        print("mpi: no mpirun, or no mpi4py for this Python")
        return
    os.environ["PYTHONPATH"] = path
    words = ("sweep", str(file), "--quiet", "--no-figures", "--out", str(folder / "mpi"))
    for number in (1, 2):
        told(f"mpi {number}", cost_of(ranks(number + 1, *words, "--fresh"), (0, 3)))
    same = _data(folder / "local/sweep.h5") == _data(folder / "mpi/sweep.h5")
    print(f"equal to the last bit: {same}")


def large(folder: Path, count: int) -> None:
    """Check of many double pendulums; sweep, file and restart of as many rigid pendulums."""
    file, used = _checked(folder, count, 0.01)
    print(f"check    {_told(used)}, {_mb(file):.2f} MB", flush=True)
    (folder / "rigid").mkdir()
    case, out = folder / "rigid/case.toml", folder / "rigid/build"
    case.write_text(RIGID.format(count=count), encoding="utf-8")
    used = cost([*PLYMOTION, "check", str(case), "--out", str(out)])
    print(f"check    {_told(used)} (rigid)", flush=True)
    file, out = out / "sweeps/s.json", folder / "out"
    used = _sweep(file, out)
    print(f"sweep    {_told(used)}, {_mb(out / 'sweep.h5'):.2f} MB", flush=True)
    used = _sweep(file, out)
    print(f"restart  {_told(used)}")


def _mb(file: Path) -> float:
    return file.stat().st_size / 1e6


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", choices=("pairs", "workers", "large"))
    parser.add_argument("count", type=int, nargs="?", help="members")
    parser.add_argument("--repeats", type=int, default=3)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        begin = time.perf_counter()
        if options.what == "pairs":
            pairs(Path(folder), options.count or 512, options.repeats)
        elif options.what == "workers":
            by_workers(Path(folder), options.count or 512)
        else:
            large(Path(folder), options.count or 10_000)
        print(f"{np.round(time.perf_counter() - begin)} s", file=sys.stderr)


if __name__ == "__main__":
    main()
