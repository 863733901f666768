"""Executors: processes of this machine, a dask cluster, an MPI job; all give the same numbers."""

import os
import signal
import subprocess
import sys
import threading
from collections import Counter
from pathlib import Path

import h5py
import numpy as np
import pytest
from harness import executor_samples as samples
from harness.dask_cluster import TESTS, Cluster, until
from harness.hostile_profile import WAIT_S
from harness.mpi_samples import ranks, with_mpi
from samples.sweep_samples import FORCE, MASS, ball, ball_plan, sweep

from plymotion.solver.__main__ import main
from plymotion.solver.errors import InputError
from plymotion.solver.studies.sweep import portions
from plymotion.solver.studies.sweep.file import read_sweep
from plymotion.solver.studies.sweep.portions import Portions
from plymotion.solver.workers import executors
from plymotion.solver.workers.executors import FRUITLESS, Here, Local, distribute

POSIX = pytest.mark.skipif(sys.platform == "win32", reason="no such signals")
MEMBERS = f"{FORCE} = [0.0, 1.0, 1e300, 2.0, 3.0]\n{MASS} = [1.0, 1.5, 2.0, 2.5]"


def data(file: Path) -> dict[str, np.ndarray]:
    """All datasets of a sweep but the time taken and the digests of rows, which have it."""
    with h5py.File(file) as h5:
        found: dict[str, np.ndarray] = {}
        h5.visititems(lambda n, d: found.update({n: d[()]}) if isinstance(d, h5py.Dataset) else 0)
    return {n: d for n, d in found.items() if n not in ("cost/solve_s", "members/sha256")}


def assert_same_bits(one: Path, two: Path) -> None:
    a, b = data(one), data(two)
    assert a.keys() == b.keys()
    for name, values in a.items():
        assert values.dtype == b[name].dtype
        assert values.tobytes() == b[name].tobytes(), name


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    """A sweep of 20 members and its results as computed in this process."""
    folder = tmp_path_factory.mktemp("alone")
    file = ball(folder, MEMBERS, 'histories = ["x"]')
    assert sweep(file, "--out", str(folder / "alone")) == 3
    return file, folder / "alone" / "sweep.h5"


@pytest.mark.usefixtures("system")
def test_processes_give_the_same(tmp_path, alone):
    file, expected = alone
    assert sweep(file, "--out", str(tmp_path / "two"), "--jobs", "2") == 3
    assert_same_bits(tmp_path / "two/sweep.h5", expected)


def test_shards_are_merged(tmp_path, alone, capsys):
    """The file of all shards has the data of one command; a missing one is told and computed."""
    file, expected = alone
    out = tmp_path / "out"
    for k in (1, 3, 2):
        expected_code = 3 if k == 2 else 0  # members 8 to 11 fail
        assert sweep(file, "--shard", f"{k}/3", "--out", str(out)) == expected_code
        assert not (out / "sweep.csv").exists()
        if k == 3:
            capsys.readouterr()
            assert main(["sweep", "--merge", str(file), "--out", str(out), "--no-figures"]) == 3
            told = capsys.readouterr()
            assert "s: 7 of 20 members are in none of 2 shards" in told.err
            assert "7 pending" in told.out
            assert "  0 computed in" in told.out
            assert not (out / "sweep.csv").exists()
    assert main(["sweep", "--merge", str(file), "--out", str(out), "--no-figures"]) == 3
    assert (out / "sweep.csv").is_file()
    assert_same_bits(out / "sweep.h5", expected)
    (out / "sweep.h5").unlink()
    (out / "sweep-2-of-3.h5").unlink()
    capsys.readouterr()
    assert sweep(file, "--out", str(out)) == 3
    assert "7 computed in" in capsys.readouterr().out
    assert_same_bits(out / "sweep.h5", expected)


def test_wrong_shards(tmp_path, capsys):
    file = ball(tmp_path, f"{FORCE} = [1.0, 2.0]")
    assert sweep(file, "--shard", "1/3") == 2
    assert "--shard 1/3: expected at most 2 shares" in capsys.readouterr().err
    assert main(["sweep", "--merge", str(file)]) == 2
    assert "no files sweep-*-of-*.h5" in capsys.readouterr().err


@POSIX
def test_a_worker_that_dies_is_replaced(tmp_path):
    source = samples.Numbers(samples.dies_at_3, tmp_path, range(8))
    distribute(Local(2), source)
    assert source.dead == [3]
    assert sorted(source.results) == [(n, n**2) for n in range(8) if n != 3]


@POSIX
def test_workers_that_all_die_end_the_command(tmp_path):
    source = samples.Numbers(samples.always_dies, tmp_path, range(9))
    with pytest.raises(InputError, match=f"--jobs 2: {FRUITLESS} workers died"):
        distribute(Local(2), source)


def test_processes_are_renewed(tmp_path, monkeypatch):
    """Memory that was not given back is free after a number of tasks."""
    monkeypatch.setattr(executors, "TASKS", 2)
    source = samples.Numbers(samples.process, tmp_path, range(6))
    distribute(Local(1), source)
    pids = [pid for _, pid in source.results]
    assert pids[0::2] == pids[1::2]
    assert len(set(pids)) == 3


def test_a_lane_keeps_its_worker(tmp_path):
    for threads in (False, True):
        source = samples.Numbers(samples.process, tmp_path, range(6))
        distribute(Local(2, threads=threads), source)
        result = dict(source.results)
        workers = [{result[n] for n in numbers} for numbers in source.lanes.values()]
        assert [len(w) for w in workers] == [1, 1]


def test_an_error_of_a_task_ends_all(tmp_path):
    source = samples.Numbers("not a function", tmp_path, range(3))
    for executor in (Here(), Local(2)):
        with pytest.raises(TypeError):
            distribute(executor, source)


def _running(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


@POSIX
@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGINT])
def test_workers_end_with_their_parent(tmp_path, number):
    """However that ends, and whatever they are at."""
    code = (
        "import sys\n"
        "from harness.executor_samples import Numbers, sleeps\n"
        "from plymotion.solver.workers.executors import distribute\n"
        "from plymotion.solver.workers.executors import Local\n"
        "if __name__ == '__main__':\n"
        "    distribute(Local(2), Numbers(sleeps, sys.argv[1], range(2)))\n"
    )
    script = tmp_path / "script.py"
    script.write_text(code)
    folder = tmp_path / "signs"
    folder.mkdir()
    path = os.pathsep.join([str(TESTS), os.environ.get("PYTHONPATH", "")])
    process = subprocess.Popen(
        [sys.executable, str(script), str(folder)],
        env=os.environ | {"PYTHONPATH": path},
        stderr=subprocess.DEVNULL,
    )
    until(lambda: len(list(folder.iterdir())) == 2)
    process.send_signal(number)
    process.wait(timeout=30)
    workers = [int(sign.name.split("-")[1]) for sign in folder.iterdir()]
    until(lambda: not any(map(_running, workers)), 20.0)


@POSIX
@pytest.mark.provokes("worker-lost")
def test_a_worker_that_dies_takes_one_member_with_it(tmp_path, monkeypatch):
    monkeypatch.setattr(portions, "compute_portion", samples.deadly_portion)
    plan = ball_plan(tmp_path, f"{FORCE} = [1.0, 2.0, 3.0, 4.0]")
    rows = {}
    source = Portions(plan, range(4), plan.keys(), rows.__setitem__)
    source._size = 4  # as after quick members
    distribute(Local(1), source)
    assert {k: row.status for k, row in rows.items()} == {
        0: "finished",
        1: "failed",
        2: "finished",
        3: "finished",
    }
    assert rows[1].code == "worker-lost"


@pytest.fixture(scope="module")
def scheduler(tmp_path_factory):
    pytest.importorskip("distributed", reason="dask.distributed is not installed")
    found = Cluster(tmp_path_factory.mktemp("cluster"))
    yield found
    found.close()


@pytest.fixture
def cluster(scheduler):
    """A scheduler without workers."""
    yield scheduler
    scheduler.end_workers()


def test_a_dask_worker_is_killed_in_the_middle(tmp_path, alone, cluster, monkeypatch):
    """Each member has one row; the numbers are those of this process to the last bit.

    The workers come later than the command, as those of a queue do.
    """
    file, expected = alone
    told = Counter()

    class Watched(Portions):
        def __init__(self, plan, numbers, keys, report):
            def counted(number, row):
                told[number] += 1
                report(number, row)

            super().__init__(plan, numbers, keys, counted)

        def next(self, lane, width):
            self._size = min(self._size, 2)  # many portions
            return super().next(lane, width)

    monkeypatch.setattr(portions, "Portions", Watched)
    monkeypatch.setattr(portions, "compute_portion", samples.noted_portion)
    workers, killed = [], []
    later = threading.Timer(2.0, lambda: workers.extend(cluster.worker() for _ in range(2)))
    took = Watched.took

    def took_and_killed(self, task, result):
        took(self, task, result)
        if not killed and {pid for pid, _ in cluster.noted()} >= {each.pid for each in workers}:
            killed.append(workers[0].pid)
            workers[0].kill()

    monkeypatch.setattr(Watched, "took", took_and_killed)
    out = tmp_path / "dask"
    later.start()
    assert sweep(file, "--out", str(out), "--scheduler", str(cluster.file)) == 3
    assert killed, "the sweep was over before a worker could be killed"
    assert told == dict.fromkeys(range(20), 1)
    first, second = workers
    by_worker = {pid: [] for pid in (first.pid, second.pid)}
    for pid, numbers in cluster.noted():
        by_worker[pid] += numbers
    survivor = Counter(by_worker[second.pid])
    assert set(survivor.values()) == {1}, "computed twice by the worker that lived"
    assert survivor.keys() | set(by_worker[first.pid]) == set(range(20))
    assert by_worker[first.pid], "the other one had no part in it"
    assert_same_bits(out / "sweep.h5", expected)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--executor", "dask"], "--executor dask: expected --scheduler ADDRESS or FILE.json"),
        (["--executor", "mpi"], "expected a start by `mpirun -n N python -m mpi4py.futures -m"),
        (["--scheduler", "s.json"], "--scheduler s.json: no such file; `dask scheduler"),
        (["--scheduler", "here:1", "--executor", "mpi"], "expected with --executor dask only"),
        (["--scheduler", "here:1", "--jobs", "2"], "--jobs 2: expected with --executor local"),
        (["--scheduler", "tcp://127.0.0.1:1"], "no dask scheduler answers there"),
    ],
)
def test_wrong_executors(tmp_path, capsys, monkeypatch, words, message):
    if "--scheduler" in words and "--executor" not in words and "--jobs" not in words:
        pytest.importorskip("distributed", reason="dask.distributed is not installed")
    monkeypatch.setattr(executors, "CONNECT_S", 1.0)
    file = ball(tmp_path, f"{FORCE} = [1.0]")
    assert sweep(file, *words) == 2
    assert message in capsys.readouterr().err


def test_ranks_of_an_mpi_job_give_the_same(tmp_path, alone):
    path = with_mpi(tmp_path / "site")
    if path is None:
        pytest.skip("no mpirun, or no mpi4py for this Python")
    file, expected = alone
    words = ["sweep", str(file), "--quiet", "--no-figures", "--out", str(tmp_path / "mpi")]
    done = subprocess.run(
        ranks(3, *words),
        env=os.environ | {"PYTHONPATH": path},
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 3, done.stderr
    assert_same_bits(tmp_path / "mpi/sweep.h5", expected)


KILLED = """
import sys
from harness import executor_samples
from plymotion.solver.__main__ import main
from plymotion.solver.studies.sweep import portions
portions.compute_portion = executor_samples.noted_portion
portions.SAVE_S = 0.0  # each row at once
sys.exit(main(sys.argv[1:]))
"""


def test_a_dask_scheduler_that_is_killed_is_a_message(tmp_path, cluster):
    """No traceback of dask; finished members are kept, and the sweep goes on without it.

    The last test of this file: the others share the scheduler.
    """
    cluster.worker()
    file = ball(tmp_path, f"{FORCE} = {[float(k) for k in range(60)]}")
    path = os.pathsep.join([str(TESTS), os.environ.get("PYTHONPATH", "")])
    words = ["sweep", str(file), "--quiet", "--no-figures", "--scheduler", str(cluster.file)]
    process = subprocess.Popen(
        [sys.executable, "-c", KILLED, *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"PYTHONPATH": path},
    )
    results = file.with_suffix("") / "sweep.h5"
    until(lambda: results.exists() and read_sweep(results).count("finished"))
    cluster.processes[0].kill()
    told, errors = process.communicate(timeout=WAIT_S)
    assert process.returncode == 2
    expected = f"error: --scheduler {cluster.file}: lost the connection to the workers\n"
    assert (told, errors) == ("", expected)
    assert 0 < read_sweep(results).count("finished") < 60
    assert sweep(file) == 0
    assert read_sweep(results).count("finished") == 60
