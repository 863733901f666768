"""Files that are edited, and signals that come, while a command is at work: real processes."""

import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from harness.forks import forks
from harness.hostile_profile import MISSED, WAIT_S, count, tries
from harness.processes import this_python
from samples.case_samples import HEAD, SOLVER, rigid
from samples.fidelity_packages import CASE, build_bodies
from samples.sweep_samples import FORCE, ball

from plymotion.solver.__main__ import main
from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.inputs.case.write import write_case
from plymotion.solver.math.compiled import COMPILED
from plymotion.solver.package.section.section_file import read_section
from plymotion.solver.results import read_summary
from plymotion.solver.studies.sweep.file import read_sweep

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="no such signals")

# Tells that it is at the first step, or that it writes; "edit": waits there for a file.
PAUSED = """
import os, sys, time
import plymotion.solver.results.datasets as d
from plymotion.solver.checks.judge import Monitors
from plymotion.solver.__main__ import main
where, go = sys.argv[1:3]
watch, put, seen = Monitors.__call__, d.Datasets.put, []
def tell():
    if not seen:
        seen.append(1)
        print("here", flush=True)
def watched(self, steps):
    if where != "write":
        tell()
    while where == "edit" and not os.path.exists(go):
        time.sleep(0.01)
    if where in ("step", "both"):
        time.sleep(0.05)
    return watch(self, steps)
def slow(*words):
    if where in ("write", "both"):
        tell()
        for _ in range(3000):
            time.sleep(0.01)
    return put(*words)
Monitors.__call__, d.Datasets.put = watched, slow
sys.exit(main(sys.argv[3:]))
"""
PUSHED = (
    rigid("ball", 1.0, 0.1, {"c": (0, 0, 0)})
    + """
[forces.push]
kind = "force"
at = "ball.c"
direction = [1, 0, 0]
law = { table = { file = "push.csv" } }
"""
)


def paused(where, go, *words):
    process = forks.started(PAUSED, where, str(go), *map(str, words))
    assert process.stdout.readline() == "here\n"
    return process


def ended(process):
    try:
        return process.communicate(timeout=WAIT_S)
    finally:
        process.kill()


@pytest.mark.parametrize("edited", ["case.toml", "push.csv"])
def test_what_is_edited_during_a_run_is_not_up_to_date(tmp_path, edited, capsys):
    """The record is of what was read. The edit keeps the size."""
    case, table = tmp_path / "case.toml", tmp_path / "push.csv"
    case.write_text(HEAD + PUSHED + SOLVER.format(t_end=2.0, step=0.5, more=""))
    table.write_text("# t,f\n0,1.0\n9,1.0\n")
    words = [str(case), "--out", str(tmp_path / "out"), "--no-report", "--quiet"]
    process = paused("edit", tmp_path / "go", *words)
    if edited == "case.toml":
        case.write_text(case.read_text().replace("t_end = 2.0", "t_end = 1.0"))
    else:
        table.write_text(table.read_text().replace("1.0\n", "2.0\n"))
    (tmp_path / "go").touch()
    _, errors = ended(process)
    assert process.returncode == 0, errors
    assert read_summary(tmp_path / "out/base/summary.json")["t_end"] == 2.0
    assert main(words) == 0
    assert "up to date" not in capsys.readouterr().out
    found = read_summary(tmp_path / "out/base/summary.json")
    if edited == "case.toml":
        assert found["t_end"] == 1.0
    assert main(words) == 0
    assert "up to date" in capsys.readouterr().out


def test_a_run_file_that_changes_while_it_is_read_is_known_by_no_digest(tmp_path, monkeypatch):
    """In this process: nobody can time an edit between two reads of a file."""
    from plymotion.solver.run import execution

    file = tmp_path / "case.toml"
    file.write_text(
        HEAD
        + rigid("ball", 1.0, 0.1, {"c": (0, 0, 0)})
        + SOLVER.format(t_end=0.1, step=0.1, more="")
    )
    write_case(load_case(file), tmp_path / "build")
    run = tmp_path / "build/runs/base.json"
    read = execution.read_run

    def edited(*words, **more):
        found = read(*words, **more)
        run.write_text(run.read_text() + " ")
        return found

    monkeypatch.setattr(execution, "read_run", edited)
    assert main(["run", str(run), "--quiet"]) == 0
    assert read_summary(tmp_path / "build/base/summary.json")["inputs_sha256"] == ""


def test_rows_of_a_sweep_that_was_changed_are_not_kept(tmp_path):
    file = ball(tmp_path, f"{FORCE} = [0.0, 1.0, 2.0]")
    process = paused("edit", tmp_path / "go", "sweep", file, "--quiet", "--no-figures")
    table = json.loads(file.read_text())
    table["mechanism"]["gravity"] = [0.0, 0.0, -1.0]
    file.write_text(json.dumps(table))
    (tmp_path / "go").touch()
    _, errors = ended(process)
    assert process.returncode == 2
    assert f"{file}: was changed while the sweep ran" in errors
    assert read_sweep(file.with_suffix("") / "sweep.h5").count("finished") == 0
    assert main(["sweep", str(file), "--quiet", "--no-figures"]) == 0
    assert read_sweep(file.with_suffix("") / "sweep.h5").count("finished") == 3


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT, signal.SIGKILL])
def test_an_interrupted_planning_leaves_nothing_that_looks_finished(tmp_path, number):
    case, out, ready = tmp_path / "case.toml", tmp_path / "build", tmp_path / "packages"
    case.write_text(CASE)
    ready.mkdir()
    words = ["check", str(case), "--out", str(out), "--packages", str(ready)]
    assert main(words) == 0
    build_bodies(out / "bodies", ready)
    run = out / "runs/base.json"
    process = paused("step", tmp_path, "run", run, "--quiet")
    process.send_signal(number)
    _, errors = ended(process)
    assert not (out / "base").exists()
    assert not (out / "plans").exists()
    if number != signal.SIGKILL:
        assert process.returncode == 128 + number
        assert "interrupted: nothing written" in errors
    assert main(["run", str(run), "--quiet", "--update"]) == 0
    summary = read_summary(out / "base/summary.json")
    assert summary["fidelity"]["verdict"] == "met"


@pytest.mark.parametrize("where", ["write", "both"])
def test_writing_stops_soon_after_a_signal(tmp_path, where):
    """Also after one that has ended the integration."""
    file = tmp_path / "case.toml"
    file.write_text(
        HEAD
        + rigid("ball", 1.0, 0.1, {"c": (0, 0, 0)})
        + SOLVER.format(t_end=0.1, step=0.1, more="max_step = 1e-3")
    )
    write_case(load_case(file), tmp_path / "build")
    process = paused(where, tmp_path, "run", tmp_path / "build/runs/base.json", "--quiet")
    begin = time.monotonic()
    process.send_signal(signal.SIGTERM)
    _, errors = ended(process)
    assert time.monotonic() - begin < 10.0  # the writing would take minutes
    assert process.returncode == 143
    assert errors.endswith("interrupted: nothing written\n")
    assert not list((tmp_path / "build").rglob(".*"))
    assert not list((tmp_path / "build/base").glob("*"))


# Prints the signals that are blocked when each process is started.
STARTS = """
import signal
from multiprocessing import util
from plymotion.solver.studies.compiling import compile_ahead
start = util.spawnv_passfds
def told(path, words, files):
    blocked = sorted(map(int, signal.pthread_sigmask(signal.SIG_BLOCK, [])))
    print("tracker" if "resource_tracker" in str(words) else "worker", *blocked, flush=True)
    return start(path, words, files)
util.spawnv_passfds = told
compile_ahead()
"""


def test_what_compiles_ahead_starts_no_process_that_hears_signals():
    """HUP ended the resource tracker, which a later worker of a sweep then missed."""
    done = this_python("-c", STARTS)
    assert done.returncode == 0, done.stderr
    if not COMPILED:
        pytest.skip("nothing is compiled")
    numbers = " ".join(str(int(n)) for n in sorted([signal.SIGHUP, signal.SIGINT, signal.SIGTERM]))
    assert sorted(done.stdout.splitlines()) == [f"tracker {numbers}", *[f"worker {numbers}"] * 2]


STORM = """
[sweeps.s]
run = "base"
vary = { end = { keys = ["solver.t_end"], values = [20.0, 30.0, 40.0, 50.0] } }
"""
COMMANDS = {"run": [], "sweep": ["--sweep", "s", "--jobs", "2"]}


def storm(command, tmp_path, words, longest, count_of_tries):
    """Strike a command at any time, once in each of many tries; yield its folder after each.

    To the process or to its group, as a terminal sends it. Before the program has begun, in the
    first 0.2 s, a signal ends Python by itself: then nothing is written or said.
    """
    random = np.random.default_rng(len(command))
    for k in range(count_of_tries):
        number = random.choice([signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
        send = os.killpg if k % 2 else os.kill
        out = tmp_path / str(k)
        process = subprocess.Popen(
            [sys.executable, "-m", "plymotion", *map(str, words), "--out", str(out)],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(random.uniform(0.0, longest))
        with contextlib.suppress(ProcessLookupError):
            send(process.pid, number)
        _, errors = ended(process)
        before = (process.returncode, errors) == (-number, "")
        if (before or errors.startswith("Fatal Python error: init_")) and not out.exists():
            continue
        assert process.returncode in (0, 128 + number), errors
        assert not any(word in errors for word in ("Traceback", "Exception", "leaked")), errors
        if "nothing written" in errors:
            assert not [file for file in out.rglob("*") if file.is_file()], errors
        yield out
        kind = f"{command}: {signal.Signals(number).name} at any time"
        count(kind, "recovered" if process.returncode else MISSED)


@pytest.mark.parametrize("command", COMMANDS)
def test_a_signal_at_any_time(tmp_path, command):
    case = tmp_path / "case.toml"
    more = SOLVER.format(t_end=20.0, step=0.01, more="max_step = 1e-3") + STORM
    case.write_text(HEAD + rigid("ball", 1.0, 0.1, {"c": (0, 0, 0)}) + more)
    longest = {"run": 3.0, "sweep": tries(3, 6)}[command]
    for _ in storm(command, tmp_path, [case, *COMMANDS[command]], longest, tries(3, 25)):
        pass


def test_a_signal_at_any_time_of_a_batch_of_sections(repository, tmp_path, fenicsx):
    """Each section file is whole, and what is missing is made by the same command."""
    names = ["square", "pendulum-arm", "channel", "i-beam", "box-layup-1", "two-cell"]
    names = names[: tries(2, 6)]
    files = [repository / f"cases/sections/{name}.toml" for name in names]
    words = ["section", *files, "--jobs", "2", "--no-figures"]
    for out in storm("section", tmp_path, words, tries(3, 8), tries(3, 66)):
        # a preprocessor that is busy for 2 s is killed; the next one removes its hidden file
        for file in out.glob("*/[!.]*.vtkhdf"):
            assert read_section(file).K.shape == (6, 6)


def test_workers_hear_no_signal_before_they_ignore_it(tmp_path):
    """They are started with signals blocked, which is in force from their first instruction."""
    if not Path("/proc/self/status").is_file():
        pytest.skip("reads masks of signals from Linux")
    from plymotion.solver.system.interrupts import shielded
    from plymotion.solver.workers.executors import _Worker

    with shielded():
        worker = _Worker(thread=False)
        found = worker.pool.submit(_blocked)
    try:
        assert found.result() >= {signal.SIGINT, signal.SIGTERM, signal.SIGHUP}
        assert _blocked() == set()
    finally:
        worker.close(at_once=False)


def _blocked():
    return set(signal.pthread_sigmask(signal.SIG_BLOCK, []))
