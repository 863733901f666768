"""INT, TERM and HUP: what is computed is kept, and the exit code tells the signal."""

import json
import os
import signal
import subprocess
import sys
import time

import pytest
from harness.dask_cluster import until
from harness.forks import forks
from harness.hostile_profile import LONG as PROFILE
from harness.hostile_profile import WAIT_S, count
from harness.processes import this_python
from samples.case_samples import HEAD, SOLVER, rigid
from samples.sweep_samples import FORCE, ball

from plymotion.solver.__main__ import main
from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.inputs.case.write import write_case
from plymotion.solver.results import read_result
from plymotion.solver.run.timing import PACE, StageProgress
from plymotion.solver.studies.sweep.file import read_sweep
from plymotion.solver.system.interrupts import (
    completing,
    ending_words,
    handled_signals,
    note_complete,
)

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="no such signals")
SIGNALS = [signal.SIGINT, signal.SIGTERM, signal.SIGHUP]
# The handler is one for all: a run gets all three, its workers and a sweep one of them.
TO_WORKERS = [signal.SIGINT, signal.SIGTERM] if PROFILE == 2 else [signal.SIGTERM]
BALL = rigid("ball", 1.0, 0.1, {"c": (0, 0, 0)})
LONG = SOLVER.format(t_end=1e5, step=1.0, more="max_step = 0.01")
SWEEP = """
[sweeps.s]
run = "base"
vary = { end = { keys = ["solver.t_end"], values = [0.1, 0.2, 1e5] } }
"""
# Tells where it is: while it steps, while it writes, while it imports.
TOLD = """
import sys, time
import plymotion.solver.run.execution as r
from plymotion.solver.studies.sweep import portions
from plymotion.solver.checks.judge import Monitors
from plymotion.solver.__main__ import main
watch, write = Monitors.__call__, r.write_result
def told(self, steps):
    if steps.t[-1] > 1.0 and not hasattr(r, "told"):
        r.told = True
        sys.stdout.write("stepping\\n"), sys.stdout.flush()
    return watch(self, steps)
def writing(path, result, **more):
    if "--slow-disk" in sys.argv:
        print("writing", flush=True)
        time.sleep(0.2)
    write(path, result, **more)
Monitors.__call__, r.write_result = told, writing
portions.SAVE_S = 0.0  # each row at once
if "--slow-disk" not in sys.argv:
    r.PATIENCE_S = 60.0  # a busy machine may need longer to save
sys.exit(main([word for word in sys.argv[1:] if word != "--slow-disk"]))
"""


def _files(folder, text):
    file = folder / "case.toml"
    file.write_text(HEAD + BALL + text)
    write_case(load_case(file), folder / "build")
    return folder / "build"


def _started(*words):
    return forks.started(TOLD, *map(str, words), "--quiet")


def _ended(process, number, words=("stepping",)):
    try:
        assert [process.stdout.readline().strip() for _ in words] == list(words)
        process.send_signal(number)
        out, errors = process.communicate(timeout=WAIT_S)
    finally:
        process.kill()
    assert process.returncode == 128 + number, errors
    assert "Traceback" not in errors
    return out, errors


def _nothing_hidden(folder):
    assert not list(folder.rglob(".*"))


@pytest.mark.parametrize("number", SIGNALS)
def test_a_run_keeps_its_part(tmp_path, number):
    build = _files(tmp_path, LONG)
    out, _ = _ended(_started("run", build / "runs/base.json"), number)
    assert "base: interrupted at t = " in out
    summary = json.loads((build / "base/summary.json").read_text())
    assert summary["status"] == "interrupted"
    assert read_result(build / "base/result.vtkhdf").t[-1] == summary["t_end"] > 1.0
    _nothing_hidden(build)
    count(f"run: {signal.Signals(number).name}, its part is kept", "done")


@pytest.mark.parametrize("number", TO_WORKERS)
def test_processes_get_the_signal_of_the_first(tmp_path, number):
    """The scheduler's signal reaches one process; two runs are under way, the third waits."""
    build = _files(tmp_path, LONG + "[runs.two]\n[runs.three]\n")
    runs = [build / f"runs/{name}.json" for name in ("base", "two", "three")]
    process = _started("run", *runs, "--jobs", "2")
    out, _ = _ended(process, number, ("stepping", "stepping"))
    for name in ("base", "two"):
        assert f"{name}: interrupted at t = " in out
        assert json.loads((build / name / "summary.json").read_text())["t_end"] > 1.0
    assert not (build / "three").exists()
    _nothing_hidden(build)
    count(f"run --jobs 2: {signal.Signals(number).name}, their parts are kept", "done")


def test_a_signal_while_results_are_written_does_not_lose_them(tmp_path):
    build = _files(tmp_path, SOLVER.format(t_end=0.1, step=0.1, more="") + "[runs.two]\n")
    runs = [build / "runs/base.json", build / "runs/two.json"]
    out, errors = _ended(_started("run", *runs, "--slow-disk"), signal.SIGTERM, ("writing",))
    assert "interrupted: completing the files, 0.3 CPU s at most" in errors  # said at once
    assert "base: done at t = 0.1 s" in out
    assert json.loads((build / "base/summary.json").read_text())["completed"]
    assert not (build / "two").exists()


def test_a_signal_while_the_last_run_is_written_leaves_out_the_report(tmp_path):
    build = _files(tmp_path, SOLVER.format(t_end=0.1, step=0.1, more=""))
    words = [tmp_path / "case.toml", "--out", build, "--slow-disk"]
    _, errors = _ended(_started(*words), signal.SIGTERM, ("writing",))
    assert errors.endswith(f"complete files are kept, the last is {build}/base/summary.json\n")
    assert not (build / "report.html").exists()


def _compute(seconds):
    end = time.process_time() + seconds
    while time.process_time() < end:
        pass


def test_a_stage_that_needs_longer_than_its_patience_ends():
    """At once: its pace is known from before the signal."""
    with handled_signals(), completing(1.0):
        slow, fast = (
            StageProgress("base", "writing", show=False, patience_s=1.0) for _ in range(2)
        )
        _compute(1.1 * PACE)
        slow(0.02)
        os.kill(os.getpid(), signal.SIGTERM)
        fast(0.5)  # the other half takes as long
        with pytest.raises(KeyboardInterrupt):
            slow(0.02)


def test_patience_is_cpu_time():
    """Of a busy machine, or a slow disk: files that take little work were lost after 0.6 s."""
    with handled_signals(), completing(0.1):
        os.kill(os.getpid(), signal.SIGTERM)
        time.sleep(0.3)
        with pytest.raises(KeyboardInterrupt):
            _compute(1.0)


def _finished(file):
    return read_sweep(file).count("finished") if file.exists() else 0


@pytest.mark.parametrize(("number", "jobs"), [(n, jobs) for jobs in ("1", "2") for n in TO_WORKERS])
def test_a_sweep_keeps_its_members(tmp_path, number, jobs):
    build = _files(tmp_path, LONG.replace("= 1.0", "= 0.1") + SWEEP)
    process = _started("sweep", build / "sweeps/s.json", "--jobs", jobs)
    if jobs == "1":
        _, errors = _ended(process, number)
    else:  # its processes say nothing
        until(lambda: _finished(build / "sweeps/s/sweep.h5") == 2, WAIT_S)
        _, errors = _ended(process, number, ())
    assert "s: interrupted; 2 of 3 members are in" in errors
    rows = read_sweep(build / "sweeps/s/sweep.h5").rows
    assert [row.status for row in rows] == ["finished", "finished", "pending"]
    _nothing_hidden(build)
    count(f"sweep: {signal.Signals(number).name}, finished members are kept", "done")


# A signal in the moment in which a module is imported.
IMPORTING = """
import os, runpy, sys
file, module, name, number = sys.argv[1:]
class Finder:
    def find_spec(found, *_):
        if found == name:
            os.kill(os.getpid(), int(number))
sys.meta_path.insert(0, Finder)
sys.argv = ["plymotion", "run", file, "--quiet"]
runpy.run_module(module, run_name="__main__")
"""
MODULES = ["plymotion.solver.commands", "numpy", "h5py", "plymotion.solver.run.execution"]


@pytest.mark.parametrize("number", SIGNALS)
def test_an_end_before_the_beginning(tmp_path, number):
    """While it starts: no traceback, nothing written. All pairs of signal, entry and module."""
    build = _files(tmp_path, LONG)
    for k, name in enumerate(MODULES):
        module = ("plymotion", "plymotion.solver")[(k + SIGNALS.index(number)) % 2]
        words = [str(build / "runs/base.json"), module, name, str(int(number))]
        done = this_python("-c", IMPORTING, *words, more={"PLYMOTION_COMPILED": "0"})
        assert done.stderr == "interrupted: nothing written\n", (module, name)
        assert done.returncode == 128 + number
        assert not (build / "base").exists()
        count(f"run: {signal.Signals(number).name} while it imports", "recovered")


def test_files_of_temporary_folders_are_not_called_kept(tmp_path):
    """The run file of `sensitivities` was, which is read from such a folder."""
    (tmp_path / "kept").touch()
    with handled_signals():
        for name in ("kept", "gone"):
            note_complete(str(tmp_path / name))
        assert ending_words().endswith(f"the last is {tmp_path / 'kept'}")
        (tmp_path / "kept").unlink()
        assert ending_words() == "interrupted: nothing written"


def test_an_ignored_signal_stays_ignored(tmp_path):
    """As with nohup."""
    build = _files(tmp_path, SOLVER.format(t_end=0.1, step=0.1, more=""))
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        process = _started("run", build / "runs/base.json", "--slow-disk")
        assert process.stdout.readline() == "writing\n"
        process.send_signal(signal.SIGHUP)
        process.communicate(timeout=WAIT_S)
    finally:
        signal.signal(signal.SIGHUP, before)
    assert process.returncode == 0


def test_handlers_are_given_back():
    before = [signal.getsignal(number) for number in SIGNALS]
    assert main(["check"]) == 2
    assert [signal.getsignal(number) for number in SIGNALS] == before


# Where a signal may come: within code that was given to `exec` as text, such as a dataclass's.
WITHIN_TEXT = """
import os, signal, sys
from plymotion.solver.system import interrupts
with interrupts.handled_signals():
    try:
        exec("os.kill(os.getpid(), signal.SIGINT)")
        code = 0
    except KeyboardInterrupt:
        code = interrupts.INTERRUPTED
    sys.exit(interrupts.exit_code(code))
"""


def test_the_exit_code_is_that_of_the_command_wherever_the_signal_comes(tmp_path):
    """CPython would end a module (`python -m`) by the signal itself, with -2."""
    (tmp_path / "within_text.py").write_text(WITHIN_TEXT)
    done = this_python(
        "-m", "within_text", more={"PYTHONPATH": os.pathsep.join([str(tmp_path), *sys.path])}
    )
    assert (done.returncode, done.stderr) == (130, "")


# A signal while the last library is imported that figures need: what is written is told.
WITHIN_FIGURES = """
import os, sys
class Finder:
    def find_spec(found, *_):
        if found == "matplotlib.figure":
            os.kill(os.getpid(), int(sys.argv[1]))
            for _ in range(1000):  # a handler that raises would do so here
                pass
            raise ImportError("of an extension in C, without a trace of the signal")
sys.meta_path.insert(0, Finder)
from plymotion.solver.__main__ import main
sys.exit(main(sys.argv[2:]))
"""


@pytest.mark.parametrize("number", SIGNALS if PROFILE == 2 else [signal.SIGTERM])
def test_a_signal_while_figures_are_imported_is_no_missing_library(tmp_path, number):
    sweep = ball(tmp_path, f"{FORCE} = [0.0, 1.0]", 'signals = ["x"]')
    words = [str(int(number)), "sweep", str(sweep), "--quiet"]
    done = this_python("-c", WITHIN_FIGURES, *words, more={"PLYMOTION_COMPILED": "0"})
    assert done.returncode == 128 + number, done.stderr
    assert done.stderr.startswith("s: interrupted; 2 of 2 members are in ")


WITHIN_A_CLASS = """
import os, signal, sys
from plymotion.solver import __main__ as program
from plymotion.solver.commands.bodies import packages
class Descriptor:
    def __set_name__(self, owner, name):
        os.kill(os.getpid(), signal.SIGTERM)
def run(options):
    class Made:
        value = Descriptor()
packages.run_info = run
sys.exit(program.main(["info", "nothing.vtkhdf"]))
"""


def test_a_signal_while_a_class_is_made_is_no_defect():
    done = this_python("-c", WITHIN_A_CLASS)
    assert (done.returncode, done.stderr) == (143, "interrupted: nothing written\n")


# Python prints what a finalizer raises, and goes on.
WITHIN_A_FINALIZER = """
import os, signal, sys, time
from plymotion.solver import __main__ as program
from plymotion.solver.commands.bodies import packages
class Dropped:
    def __del__(self):
        os.kill(os.getpid(), signal.SIGTERM)
def run(options):
    Dropped()
    time.sleep(60.0)
packages.run_info = run
sys.exit(program.main(["info", "nothing.vtkhdf"]))
"""


def test_a_signal_in_a_finalizer_is_not_lost():
    words = [sys.executable, "-c", WITHIN_A_FINALIZER]
    done = subprocess.run(words, capture_output=True, text=True, timeout=WAIT_S)
    assert (done.returncode, done.stderr) == (143, "interrupted: nothing written\n")


# A signal within a call of the file by HDF5, which writes most of it when it closes.
CLOSES = """
import signal, sys, time
from pathlib import Path
from plymotion.solver.package.common.container import new_file
from plymotion.solver.package.common.files import DiskFile
from plymotion.solver.system.interrupts import handled_signals

def inside(frame, event, _):
    if event == "call" and frame.f_code is DiskFile.write.__code__:
        sys.setprofile(None)
        signal.raise_signal(signal.SIGINT)

try:
    with handled_signals():
        with new_file(Path(sys.argv[1])) as file:
            for k in range(100):
                file[str(k)] = [float(k)] * 100
            sys.setprofile(inside)
        time.sleep(60.0)
except KeyboardInterrupt:
    print("ended")
"""


def test_a_signal_waits_for_hdf5(tmp_path):
    """An exception within its call was dropped, or ended the program by a segmentation fault."""
    done = this_python("-c", CLOSES, str(tmp_path / "sample.h5"))
    assert (done.returncode, done.stdout, done.stderr) == (0, "ended\n", "")
