"""Sweeps that are interrupted keep the members that are complete."""

import json

import numpy as np
import pytest
from harness.processes import interrupted
from samples.sweep_samples import FORCE, MASS, ball, ball_plan, result, sweep

from plymotion.solver.studies.sweep import portions
from plymotion.solver.studies.sweep.file import read_sweep
from plymotion.solver.studies.sweep.portions import compute
from plymotion.solver.studies.sweep.sweep_members import Packages


@pytest.mark.usefixtures("system")
def test_an_interruption_keeps_what_is_complete(tmp_path, monkeypatch, capsys):
    """Ctrl-C in the third portion: the file is whole, the rest is computed later."""
    file = ball(tmp_path, f"{FORCE} = {{ from = 1, to = 8, count = 8 }}")
    calls = []

    def interrupted(plan, packages, places, keys):
        calls.append(places)
        if len(calls) == 3:
            raise KeyboardInterrupt
        return compute(plan, packages, places, keys)

    with monkeypatch.context() as patch:
        patch.setattr(portions, "compute", interrupted)
        assert sweep(file) == 130
    assert not (file.with_suffix("") / "sweep.csv").exists()
    done = len(calls[0]) + len(calls[1])
    found = result(file)
    assert [row.status for row in found.rows] == ["finished"] * done + ["pending"] * (8 - done)
    assert f"{done} of 8 members are in" in capsys.readouterr().err
    assert np.isnan(found.signal("x", "max")[done:]).all()
    assert sweep(file) == 0
    assert f"{8 - done} computed" in capsys.readouterr().out
    np.testing.assert_allclose(
        result(file).signal("x", "final"), 1 + np.arange(1, 9) / 20, atol=1e-9
    )


def test_an_interruption_between_members_keeps_those_before(tmp_path, monkeypatch):
    """Ctrl-C while the second member of a portion is prepared: the first is not lost."""
    from plymotion.solver.studies.sweep import portions

    prepare = portions.prepare

    def interrupted(*arguments, **options):
        if len(calls) == 1:
            raise KeyboardInterrupt
        calls.append(1)
        return prepare(*arguments, **options)

    calls = []
    monkeypatch.setattr(portions, "prepare", interrupted)
    plan = ball_plan(tmp_path, f"{MASS} = [1, 2, 3]")
    rows = compute(plan, Packages(plan), range(3), plan.keys())
    assert [row.status for row in rows] == ["finished", "pending", "pending"]


@pytest.mark.usefixtures("system")
def test_ctrl_c_within_a_member(tmp_path):
    """A member that never ends: after SIGINT the file has the previous member."""
    vary = 'end = { keys = ["solver.t_end"], values = [0.1, 1e4] }'
    file = ball(tmp_path, vary + f"\n{FORCE} = [0.0]\n", "")
    table = json.loads(file.read_text())
    table["mechanism"]["solver"]["max_step"] = 0.1
    file.write_text(json.dumps(table))
    code = (
        "import sys\n"
        "from plymotion.solver.checks.judge import Monitors\n"
        "from plymotion.solver.__main__ import main\n"
        "watch = Monitors.__call__\n"
        "def told(self, steps):\n"
        "    print('stepping', flush=True) if steps.t[-1] > 5 else None\n"
        "    return watch(self, steps)\n"
        "Monitors.__call__ = told\n"
        "sys.exit(main(sys.argv[1:]))\n"
    )
    returned, _, words = interrupted(code, "sweep", file, "--quiet")
    assert returned == 130, words
    assert "1 of 2 members are in" in words
    assert [row.status for row in result(file).rows] == ["finished", "pending"]


def test_saving_on_the_way(tmp_path, monkeypatch):
    """After a crash of the machine, the last saved file exists."""
    monkeypatch.setattr(portions, "SAVE_S", 0.0)
    seen = []
    save = portions.write_sweep

    def watched(path, found):
        save(path, found)
        seen.append(read_sweep(path).count("finished"))

    monkeypatch.setattr(portions, "write_sweep", watched)
    file = ball(tmp_path, f"{FORCE} = [1.0, 2.0, 3.0]")
    assert sweep(file) == 0
    assert seen == [1, 2, 3, 3]
