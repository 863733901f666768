"""`plymotion run` with several run files: each by itself, one process or more."""

import json
import os
import select
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from samples.case_samples import HEAD, SOLVER, rigid

from plymotion.solver.__main__ import main
from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.inputs.case.write import write_case
from plymotion.solver.run.timing import PHASES
from plymotion.solver.studies import runs
from plymotion.solver.system.interrupts import handled_signals
from plymotion.solver.system.platform import context, processes

BALL = rigid("ball", 1.0, 0.1, {"c": (0, 0, 0)})
# grows beyond all numbers: the run stops early
PUSH = """
[variants.pushed.forces.push]
kind = "force"
at = "ball.c"
direction = [1.0, 0.0, 0.0]
law = { polynomial = [0.0, 0.0, 0.0, 1e300] }
[runs.pushed]
variants = ["pushed"]
"""
LONG = """
[variants.long.solver]
t_end = 1e5
output_step = 1.0
max_step = 1e-3
[runs.long]
variants = ["long"]
[runs.longer]
variants = ["long"]
[runs.last]
variants = ["long"]
"""
# Tells of the first step of each run; worker processes are copies.
TOLD = """
import sys, plymotion.solver.run.execution as r
from plymotion.solver.__main__ import main
begin, step = r.Progress.__init__, r.Progress.__call__
def begun(self, watch, t_end, label, show):
    begin(self, watch, t_end, label, show)
    self.label = label
def told(self, integrator):
    if self.label:
        sys.stdout.write(self.label + " steps\\n"), sys.stdout.flush()
        self.label = ""
    return step(self, integrator)
r.Progress.__init__, r.Progress.__call__ = begun, told
sys.exit(main(sys.argv[1:]))
"""


def _runs(folder: Path, more: str) -> Path:
    file = folder / "case.toml"
    file.write_text(HEAD + BALL + SOLVER.format(t_end=0.1, step=0.01, more="") + more)
    write_case(load_case(file), folder / "build")
    return folder / "build/runs"


@pytest.mark.parametrize("jobs", ["1", "2"])
@pytest.mark.usefixtures("system")
def test_runs_that_fail_keep_the_others(tmp_path, capsys, jobs):
    runs = _runs(tmp_path, PUSH)
    wrong = runs / "wrong.json"
    wrong.write_text("{}")
    files = [str(runs / "pushed.json"), str(wrong), str(runs / "base.json")]
    assert main(["run", *files[:1], files[2], "--jobs", jobs, "--quiet"]) == 3
    assert main(["run", *files, "--jobs", jobs, "--quiet", "--out-dir", str(tmp_path / "o")]) == 2
    told = capsys.readouterr()
    assert "wrong.json: not a run file" in told.err
    assert told.out.count("base: done at t = 0.1 s") == 2
    for folder in (tmp_path / "build", tmp_path / "o"):
        done = {
            run: json.loads((folder / run / "summary.json").read_text())["completed"]
            for run in ("base", "pushed")
        }
        assert done == {"base": True, "pushed": False}
    assert not (tmp_path / "o/wrong").exists()


def test_only_changed_runs_are_computed_again(tmp_path, capsys):
    runs = _runs(tmp_path, "[runs.other]\n")
    command = ["run", "--update", "--quiet", str(runs / "base.json"), str(runs / "other.json")]
    assert main(command) == 0
    capsys.readouterr()
    assert main(command) == 0
    assert capsys.readouterr().out == "base: up to date\nother: up to date\n"
    text = (runs / "other.json").read_text()
    (runs / "other.json").write_text(text.replace('"t_end": 0.1', '"t_end": 0.2'))
    (tmp_path / "build/base/result.vtkhdf").unlink()
    assert main(command) == 0
    told = capsys.readouterr().out
    assert "base: done at t = 0.1 s" in told
    assert "other: done at t = 0.2 s" in told


def test_summary_and_option_tell_where_the_time_goes(tmp_path, capsys):
    runs = _runs(tmp_path, "")
    assert main(["run", str(runs / "base.json"), "--quiet", "--timing"]) == 0
    assert "CPU seconds: import" in capsys.readouterr().out
    seconds = json.loads((tmp_path / "build/base/summary.json").read_text())["cost"]["seconds"]
    assert tuple(seconds) == PHASES
    assert all(value >= 0.0 for value in seconds.values())
    assert seconds["integrate"] > 0.0


def test_out_is_for_one_run(tmp_path, capsys):
    runs = _runs(tmp_path, PUSH)
    files = [str(runs / "base.json"), str(runs / "pushed.json")]
    assert main(["run", *files, "--out", str(tmp_path / "o")]) == 2
    assert "expected with one run file only; use --out-dir" in capsys.readouterr().err
    assert not (tmp_path / "o").exists()


@pytest.mark.skipif(
    context().get_start_method() != "fork", reason="elsewhere workers are no copies"
)
def test_ctrl_c_keeps_the_parts_of_all_processes(tmp_path):
    """Two runs are under way, the third never begins."""
    runs = _runs(tmp_path, LONG)
    names = ("long", "longer", "last")
    command = [sys.executable, "-c", TOLD, "run", "--jobs", "2", "--quiet"]
    process = subprocess.Popen(
        [*command, *(str(runs / f"{name}.json") for name in names)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,  # Ctrl-C reaches all processes of a group
        env=os.environ | {"PLYMOTION_COMPILED": "0"},
    )
    try:
        stepping = {process.stdout.readline(), process.stdout.readline()}
        assert stepping == {"long steps\n", "longer steps\n"}
        os.killpg(process.pid, signal.SIGINT)
        words, errors = process.communicate(timeout=60)
    finally:
        process.kill()
    assert process.returncode == 130, errors
    for name in ("long", "longer"):
        assert f"{name}: interrupted at t = " in words
        assert (tmp_path / "build" / name / "result.vtkhdf").is_file()
    assert not (tmp_path / "build/last").exists()


class _Late:
    def __del__(self):
        signal.raise_signal(signal.SIGINT)


def _signal_in_a_finalizer():
    """Python drops the exception of the first one; the second is that of the parent process."""
    _Late()
    signal.raise_signal(signal.SIGINT)
    time.sleep(5.0)


@pytest.mark.skipif(
    context().get_start_method() != "fork", reason="elsewhere workers are no copies"
)
@pytest.mark.parametrize("before", [True, False])
def test_a_worker_that_has_the_signal_before_its_parent_stops(tmp_path, before):
    """A run that begins after the signal, or goes on after it, would take its whole time."""
    run = os.abort if before else _signal_in_a_finalizer
    with handled_signals(), processes(1, runs._begin, context().Event()) as pool:
        if before:
            pool.submit(signal.raise_signal, signal.SIGINT).result()
        task = runs._Task(tmp_path / "a.json", False, run)
        assert pool.submit(runs._in_worker, task).result().code == 130


@pytest.mark.skipif(
    context().get_start_method() != "fork", reason="elsewhere workers are no copies"
)
def test_workers_end_with_a_command_that_is_killed(tmp_path):
    runs = _runs(tmp_path, LONG)
    files = [str(runs / f"{name}.json") for name in ("long", "longer")]
    process = subprocess.Popen(
        [sys.executable, "-c", TOLD, "run", "--jobs", "2", "--quiet", *files],
        stdout=subprocess.PIPE,
        text=True,
        env=os.environ | {"PLYMOTION_COMPILED": "0"},
    )
    with process.stdout as output:
        begun = {output.readline(), output.readline()}
        process.kill()
        process.wait(60)
        assert begun == {"long steps\n", "longer steps\n"}
        # Each worker holds the other end of this pipe as long as it lives.
        assert select.select([output], [], [], 60.0)[0], "workers go on"
        assert output.read() == ""


WITHOUT = """
import sys
sys.modules[sys.argv.pop(1)] = None
from plymotion.solver.__main__ import main
sys.exit(main(sys.argv[1:]))
"""


def _without(module, *words, **environment):
    command = [sys.executable, "-c", WITHOUT, module, *map(str, words)]
    known = {k: v for k, v in os.environ.items() if k != "PLYMOTION_COMPILED"}
    return subprocess.run(command, capture_output=True, text=True, env=known | environment)


def test_a_run_without_numba_says_that_it_is_slow(tmp_path):
    file = _runs(tmp_path, "") / "base.json"
    done = _without("numba", "run", file, "--quiet")
    assert done.returncode == 0, done.stderr
    assert done.stderr.count("warning: Numba is not installed: runs take about thirty times") == 1
    wanted = _without("numba", "run", file, "--quiet", PLYMOTION_COMPILED="0")
    assert (wanted.returncode, wanted.stderr) == (0, "")


def test_modes_without_matplotlib_have_their_numbers(tmp_path):
    _runs(tmp_path, "")
    words = ("modes", tmp_path / "case.toml", "--out", tmp_path / "o")
    done = _without("matplotlib", *words, PLYMOTION_COMPILED="0")
    assert done.returncode == 2
    assert "figures need matplotlib, which is not installed; expected `pip install" in done.stderr
    assert "degrees of freedom" in done.stdout
    assert (tmp_path / "o/modes.json").is_file()
