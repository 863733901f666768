"""Faults while a command works: all files stay readable, and the same command goes on.

A process is killed, is told to end, or finds the disk full: before and after each renaming of a
temporary file (between result and summary, between figures and table), while it integrates, and at
any time.
"""

import os
import subprocess
import sys
import time

import pytest
from harness import struck_samples as samples
from harness.hostile_profile import LONG, MISSED, WAIT_S, count
from harness.struck_samples import changed, commands, end_of, names, number_of, struck, times_passed
from samples.sweep_samples import FORCE, ball

from plymotion.solver.__main__ import main

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="no such signals")
KINDS = ["before SIGKILL", "after SIGKILL", "before SIGTERM", "after SIGTERM", "before full"]
KINDS += ["before SIGINT", "after SIGINT", "before SIGHUP", "after SIGHUP"]
SIGNALS = ["SIGINT", "SIGTERM", "SIGHUP", "SIGKILL"]


@pytest.fixture(scope="module")
def project(tmp_path_factory):
    """A case that is checked and computed."""
    return samples.project(tmp_path_factory.mktemp("faults") / "project")


def _try(project, folder, command, kind, place, told, *, last=False):
    """Strike once; `last`: what is struck is the last thing that the command does."""
    words = changed(project, folder, command)
    done = struck(kind, place, words)
    assert "struck" in done.stderr, f"{kind} {place}: not passed"
    end = end_of(done, number_of(kind), folder, words, names(project))
    count(f"{command}: {told}", MISSED if last and end == "done" else end)
    assert end in ("recovered", "done"), f"{kind} {place}: exit {done.returncode}: {done.stderr}"
    return end


@pytest.mark.parametrize("command", ["check", "run", "sweep"])
def test_at_every_temporary_file(project, tmp_path, command):
    renamed = times_passed("before none", changed(project, tmp_path / "copy", command))
    assert renamed >= {"check": 1, "run": 2, "sweep": 3}[command]
    tries = [(kind, place) for kind in KINDS for place in range(1, renamed + 1)]
    if LONG == 1:
        tries = [("before SIGINT", 1) if command == "run" else ("before SIGKILL", renamed)]
    for kind, place in tries:
        when, what = kind.split()
        # A folder for each: a process looks for hidden files once in each folder.
        folder = tmp_path / f"{kind}-{place}"
        told = f"{what} {when} a temporary file is renamed"
        last = when == "after" and place == renamed
        _try(project, folder, command, kind, place, told, last=last)


@pytest.mark.parametrize("command", ["run", "sweep"])
def test_while_it_integrates(project, tmp_path, command):
    """Each time the command ends by the signal: nothing of the run is written yet."""
    passed = times_passed("stepping none", changed(project, tmp_path / "copy", command))
    places = sorted({1, passed // 2, passed}) if LONG == 2 else [passed]
    for name in SIGNALS if LONG == 2 else ["SIGINT"]:
        for place in places:
            folder, kind = tmp_path / f"{name}-{place}", f"stepping {name}"
            told = f"{name} while it integrates"
            assert _try(project, folder, command, kind, place, told) == "recovered"


@pytest.mark.parametrize("command", ["check", "run", "sweep"] if LONG == 2 else ["run"])
def test_at_any_time(project, tmp_path, command):
    """While it imports, reads, checks, integrates, draws, writes."""
    begin = time.monotonic()
    words = changed(project, tmp_path / "whole", command)
    program = [sys.executable, "-m", "plymotion"]
    environment = os.environ | {"PLYMOTION_COMPILED": "0"}
    subprocess.run([*program, *words], capture_output=True, env=environment, check=True)
    whole = time.monotonic() - begin
    for name in SIGNALS if LONG == 2 else ["SIGTERM"]:
        for share in [0.05, 0.2, 0.35, 0.5, 0.65, 0.8] if LONG == 2 else [0.5]:
            folder = tmp_path / f"{name}-{share}"
            words = changed(project, folder, command)
            process = subprocess.Popen(
                [*program, *words],
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                text=True,
                env=environment,
            )
            time.sleep(share * whole)
            process.send_signal(number_of(name))
            out, told = process.communicate(timeout=WAIT_S)
            done = subprocess.CompletedProcess(words, process.returncode, out, told)
            number = number_of(name)
            if number == 9 and done.returncode == 0:
                number = 15  # it had ended before
            before = told.startswith("Fatal Python error: init_")
            if before or (number != 9 and done.returncode == -number and not told):
                # Before Python begins, or when it ends: as if killed.
                done.returncode, done.stderr, number = -9, "", 9
            end = end_of(done, number, folder, words, names(project))
            count(f"{command}: {name} at any time", MISSED if end == "done" else end)
            assert end in ("recovered", "done"), f"{name}: {process.returncode}: {told}"


@pytest.fixture
def small_disk(tmp_path):
    """A file system without room; root may mount one."""
    folder = tmp_path / "disk"
    folder.mkdir()
    words = ["mount", "-t", "tmpfs", "-o", "size=160k", "none", str(folder)]
    try:
        if subprocess.run(words, capture_output=True).returncode:
            pytest.skip("no file system can be mounted here")
    except FileNotFoundError:
        pytest.skip("there is no mount")
    yield folder
    subprocess.run(["umount", str(folder)], check=True)


@pytest.mark.parametrize("command", ["check", "run", "sweep"])
def test_a_small_disk(small_disk, command):
    """Earlier results stay, the message says what is missing, and with room the command goes on."""
    folder = small_disk / "p"
    ball(folder, f"{FORCE} = [0.0, 1.0]", 'histories = ["x"]\nsignals = ["x"]')
    known = {k: [*w, "--no-figures"] if k == "sweep" else w for k, w in commands(folder).items()}
    for words in known.values():
        assert main(words) == 0
    before = {f: f.read_bytes() for f in folder.rglob("*") if f.is_file()}
    fill = small_disk / "fill"
    ends = []
    for left in (0, 1, 2, 4, 6) if LONG == 2 else (0,):
        free = os.statvfs(small_disk)
        fill.write_bytes(b"x" * max(0, (free.f_bavail - left) * free.f_frsize))
        more = {"check": [], "run": [], "sweep": ["--fresh"]}[command]
        if command == "check":
            case = folder / "case.toml"
            case.write_text(before[case].decode().replace("t_end = 1.0", "t_end = 2.0"))
        words = [*known[command], *more]
        done = struck("before none", 0, words, PLYMOTION_CACHE="/nonexistent")
        end = "refused" if done.returncode == 2 else "done" if done.returncode == 0 else "other"
        if "Traceback" in done.stderr:
            end = "traceback"
        if samples.unreadable(folder) or (
            end == "refused" and not before.keys() <= set(folder.rglob("*"))
        ):
            end = "file lost"
        count(f"{command}: a disk without room", end)
        ends.append(end)
        assert end in ("refused", "done"), done.stderr
        assert end == "done" or "No space left on device" in done.stderr
        fill.unlink()
        assert main(known[command]) == 0
        assert not list(folder.rglob(".*"))
    assert ends[0] == "refused"
