"""After any fault, make goes on by itself; then it has nothing to do, and no hidden file stays."""

import os
import subprocess
import sys
import time

import pytest
from harness.hostile_profile import LONG, MISSED, count
from harness.make_samples import Project
from samples.case_samples import HEAD, SOLVER, rigid

from plymotion.solver.package.common.files import RECORD, temporary_sibling, write_text

CASE = (
    HEAD
    + rigid("ball", 1.0, 0.1, {"c": (0, 0, 0)})
    + SOLVER.format(t_end=0.02, step=0.01, more="")
    + '[runs.two]\n[sweeps.s]\nrun = "base"\nvary = { "bodies.ball.mass" = [1.0, 2.0] }\n'
    + '[signals.x]\nkind = "position"\nat = "ball.c"\ncomponent = "x"\n'
)
TARGETS = ("one", "one-sweep-s")
DONE = "build/one/report.html: up to date\nbuild/one/sweeps/s: up to date\n"


_seconds: dict[str, float] = {}  # what make takes on this machine, busy as it is


@pytest.fixture(scope="module")
def project(repository, tmp_path_factory):
    """A case whose runs and sweep are done."""
    project = Project(repository, tmp_path_factory.mktemp("make") / "project")
    project.case("one", CASE)
    begin = time.monotonic()
    done = project.make(*TARGETS)
    _seconds["whole"] = time.monotonic() - begin
    assert done.returncode == 0, done.stdout
    return project


def _remove(path):
    path.unlink()


def _empty(path):
    path.write_bytes(b"")


NAMES = [
    "base/summary.json",
    "two/result.vtkhdf",
    "runs/base.json",
    "manifest.json",
    "case.json",
    "report.html",
    "sweeps/s.json",
    "sweeps/s/sweep.h5",
]


@pytest.mark.parametrize("names", [NAMES] if LONG == 1 else [[name] for name in NAMES])
def test_lost_and_empty_files(project, names):
    """What a killed process or a full disk may leave, and what a user may remove."""
    files = [project.folder / "build/one" / name for name in names]
    before = [bool(file.read_bytes()) for file in files]
    for fault in (_remove, _empty):
        for file in files:
            fault(file)
            if fault is _empty and file.parent.name in ("runs", "sweeps"):
                file.unlink()  # never empty: it appears under its name when complete
        project.again(*TARGETS)
        assert [bool(file.read_bytes()) for file in files] == before
        assert project.again(*TARGETS) == DONE
        for _ in files:
            count("make: a file is missing or empty", "recovered")


def _undo(project):
    for name in ("report.html", "sweeps/s/sweep.csv", "finished.json"):
        (project.folder / "build/one" / name).unlink(missing_ok=True)
    for name in ("base", "two"):
        (project.folder / "build/one" / name / "summary.json").unlink(missing_ok=True)


@pytest.mark.parametrize("share", [0.4] if LONG == 1 else [0.1, 0.2, 0.3, 0.4, 0.5, 0.7, 0.9])
def test_killed_at_any_time(project, share):
    """All processes at once, as the machine's power."""
    if LONG == 2 and "again" not in _seconds:
        _undo(project)
        begin = time.monotonic()
        assert project.make(*TARGETS).returncode == 0
        _seconds["whole"] = _seconds["again"] = time.monotonic() - begin
    _undo(project)
    process = subprocess.Popen(
        ["make", "-j1", "-o", ".venv/installed", "-o", "build/compiled", *TARGETS],
        cwd=project.folder,
        env=os.environ | {"PYTHONPATH": str(project.folder), "PLYMOTION_COMPILED": "0"},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    time.sleep(share * _seconds["whole"])
    hit = process.poll() is None
    if hit:
        os.killpg(process.pid, 9)
        process.wait()
    done = project.make(*TARGETS)
    assert done.returncode == 0, done.stdout
    assert project.make(*TARGETS).stdout == DONE
    assert not [path for path in (project.folder / "build/one").rglob(".*")]
    count("make: SIGKILL of all processes at any time", "recovered" if hit else MISSED)


def test_hidden_files_of_killed_processes_go(project):
    left = project.folder / "build/one/base"
    code = (
        "import os, sys, signal; from pathlib import Path\n"
        "from plymotion.solver.package.common.files import temporary_sibling\n"
        "with temporary_sibling(Path(sys.argv[1])) as file:\n"
        "    file.write_text('half'); os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    subprocess.run([sys.executable, "-c", code, str(left / "result.vtkhdf")], check=False)
    assert list(left.glob(".*"))
    (left / "summary.json").unlink(missing_ok=True)
    assert project.make("one").returncode == 0
    assert not list(left.glob(".*"))


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
def test_hidden_files_of_a_process_that_nobody_has_waited_for_go(tmp_path):
    """The kernel keeps its number until its parent asks: it is not running any more."""
    ended = subprocess.Popen([sys.executable, "-c", ""])
    os.waitid(os.P_PID, ended.pid, os.WEXITED | os.WNOWAIT)
    with temporary_sibling(tmp_path / "first") as own:
        left = own.with_name(own.name.replace(f"-{os.getpid()}-", f"-{ended.pid}-"))
        left.write_text("half")
        own.write_text("whole")
    folder = tmp_path / "moved"  # folders are looked through once by each process
    folder.mkdir()
    (tmp_path / left.name).rename(folder / left.name)
    write_text(folder / "second", "whole")
    assert {file.name for file in folder.iterdir()} == {"second", RECORD}
    ended.wait()
