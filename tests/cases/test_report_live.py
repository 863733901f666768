"""`plymotion report --live` shows runs under way; the runs themselves do not change."""

import json
import os
import signal
import subprocess
import sys

import numpy as np
import pytest
from samples.case_samples import HEAD, SOLVER, rigid

from plymotion.solver.__main__ import main
from plymotion.solver.math.rows import StoredRows, reopen_stored
from plymotion.solver.results import read_result
from plymotion.solver.studies.live import live_page
from plymotion.solver.system.platform import can_fork

PENDULUM = (
    HEAD
    + "gravity = [0.0, -9.81, 0.0]\n"
    + rigid("bar", 1.0, 0.1, {"root": (0, 0, 0), "tip": (1, 0, 0)}, angular_velocity=(0, 0, 2.0))
    + '[joints.hinge]\nkind = "revolute"\nbetween = ["ground.o", "bar.root"]\n'
    "axis = [0.0, 0.0, 1.0]\n[ground.o]\nposition = [0.0, 0.0, 0.0]\n"
    '[signals.angle]\nkind = "joint"\njoint = "hinge"\ncoordinate = "angle"\n'
)


@pytest.mark.skipif(not can_fork(), reason="no copies of processes")
@pytest.mark.provokes("run-under-way")
def test_a_run_under_way_is_shown_and_not_changed(tmp_path):
    (tmp_path / "case.toml").write_text(PENDULUM + SOLVER.format(t_end=9e4, step=0.2, more=""))
    out = tmp_path / "out"
    words = ["case.toml", "--out", str(out), "--jobs", "1"]
    program = [sys.executable, "-m", "plymotion", *words]
    with subprocess.Popen(program, cwd=tmp_path, stderr=subprocess.PIPE, text=True) as process:
        try:
            while "runs: 1" not in (line := process.stderr.readline()):
                assert line
            pages = live_page(out)
            page = next(pages)
            text = page.read_text(encoding="utf-8")
            assert "under way, at t = " in text
            assert "http-equiv='refresh'" in text
            assert "<p class='verdict bad'" not in text
            part = read_result(out / "live/base/result.vtkhdf")
            summary = json.loads((out / "live/base/summary.json").read_text())
            assert not summary["completed"]
            assert "run-under-way" in [w["code"] for w in summary["warnings"]]
            process.send_signal(signal.SIGINT)
            process.communicate(timeout=60)
        finally:
            process.kill()
    assert list(pages)[1:] == []  # the command has ended
    assert "report.html" in page.read_text(encoding="utf-8")
    whole = read_result(out / "base/result.vtkhdf")
    assert 0.0 < part.t[-1] < whole.t[-1]
    k = len(part.t) - 1  # its last row lies between output times
    np.testing.assert_array_equal(part.t[:k], whole.t[:k])
    np.testing.assert_array_equal(np.asarray(part.q[:k]), np.asarray(whole.q[:k]))


@pytest.mark.skipif(not can_fork(), reason="no copies of processes")
def test_a_copy_has_its_own_place_in_a_file_of_rows(tmp_path):
    """What a copy reads and adds does not move the place at which the other process reads."""
    rows, block = StoredRows((100,), tmp_path), np.arange(1e5).reshape(1000, 100)
    rows.append(block)
    np.testing.assert_array_equal(rows.read(0, 1000), block)
    place = rows._file.fileno()
    os.lseek(place, 8, os.SEEK_SET)
    child = os.fork()
    if not child:
        good = False
        try:
            reopen_stored()
            good = all(np.array_equal(rows.read(k, k + 99), block[k : k + 99]) for k in range(900))
            rows.append(-block)
            good &= np.array_equal(rows.read(1000, 2000), -block)
        finally:
            os._exit(not good)
    assert os.waitpid(child, 0)[1] == 0
    assert os.lseek(place, 0, os.SEEK_CUR) == 8
    rows.append(2.0 * block)
    np.testing.assert_array_equal(rows.read(1000, 2000), 2.0 * block)


def test_nothing_is_at_work(tmp_path, capsys):
    """A folder without a command at work is refused, and nothing is written there."""
    assert main(["report", "--live", str(tmp_path)]) == 2
    assert "no command is at work there" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
